//! What is rendered: groups of gait cycles, and the rows of a picture that they make.

use crate::draw::sweep::{Moments, Settings, Shot, View, silhouettes};
use crate::draw::template::{Builder, Template};
use crate::error::Result;
use crate::report::{SheetRow, cells};
use edgegait_core::pack::Pack;
use edgegait_core::silhouette::{AnySilhouette, Size};

/// What belongs together: a walk under a condition from each viewpoint, or the gait cycles of a
/// recording.
pub(super) struct ShownGroup {
    /// The person, the walk and its condition, or the recording.
    pub(super) name: String,
    /// What the members are, together.
    pub(super) together: String,
    /// At least one.
    pub(super) members: Vec<ShownCycle>,
    /// How long a frame is shown, seconds.
    pub(super) each_s: f64,
    /// The number of the second frame of the first member that a terminal shows, and what the two
    /// are.
    pub(super) later: (usize, String),
}

/// A gait cycle from one viewpoint.
pub(super) struct ShownCycle {
    /// The viewpoint, or which cycle it is.
    pub(super) name: String,
    pub(super) frames: Vec<AnySilhouette>,
}

impl ShownGroup {
    /// Draws a walk.
    pub(super) fn of_shot(pack: &Pack<'_>, shot: Shot<'_>, settings: Settings) -> Result<Self> {
        let condition = shot.job.condition;
        let under = condition.map(|condition| format!(", {}", condition.name));
        let views = shot
            .views
            .iter()
            .map(|view| from(std::slice::from_ref(view)));
        let drawn = silhouettes(pack, shot, settings)?;
        let members: Vec<ShownCycle> = { views.zip(drawn) }
            .map(|(name, frames)| ShownCycle { name, frames })
            .collect();
        let frames = members.first().map_or(0, |member| member.frames.len());
        let walk = pack.walk(shot.job.walk);
        let duration_s = walk
            .and_then(|walk| pack.clip(walk.clip))
            .map(|clip| clip.duration_s());
        let seen = shot.views.first().map(|view| {
            let (azimuth, elevation) = (view.azimuth_deg, view.elevation_deg);
            format!("azimuth {azimuth}, elevation {elevation} degrees; ")
        });
        let seen = seen.unwrap_or_default();
        let (each_s, later) = match shot.moments {
            Moments::Seconds { start_s, fps, .. } => {
                let last = frames.saturating_sub(1);
                let end_s = start_s + last as f64 / fps;
                let when = format!("{start_s:.3} and {end_s:.3} s");
                (1.0 / fps, (last, seen + &when))
            }
            Moments::Cycle => (
                duration_s.unwrap_or(1.0) / frames.max(1) as f64,
                (frames / 4, seen + "phases 0 and 0.25"),
            ),
        };
        Ok(Self {
            name: who(pack, shot.job.walk) + &under.unwrap_or_default(),
            together: from(shot.views),
            members,
            each_s,
            later,
        })
    }

    /// Returns the label of all members together.
    fn label(&self) -> String {
        format!("{}, {}", self.name, self.together)
    }

    /// Returns the row of a moving picture at a moment; a shorter cycle begins again.
    pub(super) fn at(&self, moment: usize) -> SheetRow {
        let of = |member: &ShownCycle| pixels(&member.frames[moment % member.frames.len()]);
        SheetRow {
            label: self.label(),
            images: self.members.iter().map(of).collect(),
        }
    }
}

/// Returns the rows of a contact sheet: a row of frames for each member; for one template, a row of
/// members for each group; for several, a row of templates for each member.
pub(super) fn rows(
    groups: &[ShownGroup],
    templates: &[Template],
    size: Size,
) -> Result<Vec<SheetRow>> {
    let shown = |template: &Template, member: &ShownCycle| {
        let bytes = made(*template, &member.frames, size)?;
        Ok(cells(&bytes, template.shape(size), size))
    };
    let joined = |images: Result<Vec<Vec<Vec<u8>>>>| images.map(|images| images.concat());
    let mut rows = Vec::new();
    for group in groups {
        if let [template] = templates {
            let images = group.members.iter().map(|member| shown(template, member));
            rows.push(SheetRow {
                label: group.label(),
                images: joined(images.collect())?,
            });
            continue;
        }
        for member in &group.members {
            let images = match templates {
                [] => member.frames.iter().map(pixels).collect(),
                several => joined(several.iter().map(|of| shown(of, member)).collect())?,
            };
            rows.push(SheetRow {
                label: format!("{}, {}", group.name, member.name),
                images,
            });
        }
    }
    Ok(rows)
}

/// Returns the number of silhouettes in all groups.
pub(super) fn count(groups: &[ShownGroup]) -> usize {
    let members = groups.iter().flat_map(|group| &group.members);
    members.map(|member| member.frames.len()).sum()
}

/// Returns the bytes of a frame.
pub(super) fn pixels(frame: &AnySilhouette) -> Vec<u8> {
    frame.to_coverage().pixels().to_vec()
}

/// Makes a template from the frames of a cycle.
pub(super) fn made(template: Template, frames: &[AnySilhouette], size: Size) -> Result<Vec<u8>> {
    let mut builder = Builder::new(template, size, frames.len() as u32);
    for frame in frames {
        builder.add(frame)?;
    }
    Ok(builder.finish())
}

/// Returns viewpoints in words.
fn from(views: &[View]) -> String {
    let is_level = views.iter().all(|view| view.elevation_deg == 0.0);
    let angles = views.iter().map(|view| match is_level {
        true => view.azimuth_deg.to_string(),
        false => format!("{}/{}", view.azimuth_deg, view.elevation_deg),
    });
    let what = if is_level {
        "azimuth"
    } else {
        "azimuth/elevation"
    };
    format!("{what} {}", angles.collect::<Vec<_>>().join(", "))
}

/// Returns the names of a walk's person and of the walk.
fn who(pack: &Pack<'_>, walk: usize) -> String {
    let Some(walk) = pack.walk(walk) else {
        return String::new();
    };
    let subject = pack.subject(walk.subject);
    format!(
        "{}, {}",
        subject.map_or("", |subject| subject.name),
        walk.name
    )
}
