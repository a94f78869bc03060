//! The markers of a file that have a known place on the body, and their tracks.

use glam::{DQuat, DVec3};

use super::names::{MarkerPlace, MarkerSide, Segment, Site, place_of};
use crate::import::{Markers, person_of};
use crate::people::retarget::rest_pose::nearest_axis;
use crate::people::retarget::unit::{UnitFamily, choose_unit};

/// Hip-to-knee-to-ankle length over the distance from the middle of the anterior iliac spines to
/// the ankle marker: medians of 0.895 to 0.933 in six clips in which Plug-in Gait states the joint
/// centres (measured 2026-11-21).
const LEG_OF_PELVIS_TO_ANKLE: f64 = 0.91;

/// A marker and its track.
#[derive(Clone, Debug)]
pub(super) struct Mark {
    /// The marker's name as spelled in the file.
    pub(super) name: String,
    pub(super) site: Site,
    pub(super) side: MarkerSide,
    /// Position by frame; none where the marker was not seen.
    pub(super) track: Vec<Option<DVec3>>,
}

impl Mark {
    /// Returns the number of frames in which the marker was seen.
    pub(super) fn seen(&self) -> usize {
        self.track.iter().flatten().count()
    }

    /// Returns the segment that carries the marker, with its side.
    pub(super) fn body(&self) -> (Segment, MarkerSide) {
        let side = match self.site.segment() {
            // The pelvis, the thorax and the head each carry markers of both sides.
            Segment::Pelvis | Segment::Thorax | Segment::Head => MarkerSide::Middle,
            _ => self.side,
        };
        (self.site.segment(), side)
    }
}

/// The markers of a file whose places are known.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    pub(super) sample_rate_hz: f64,
    pub(super) frames: usize,
    pub(super) all: Vec<Mark>,
}

/// Returns the people whose pelvis is marked, by the prefixes of their markers, in order of name.
pub(in crate::people) fn people(markers: &Markers) -> Vec<&str> {
    let worn = |wanted: MarkerSide| {
        let names = markers.names.iter();
        names.filter(move |name| place_of(name) == Some((Site::Asis, wanted)))
    };
    let person = |name: &'_ String| person_of(name).unwrap_or_default().to_owned();
    let right: Vec<String> = worn(MarkerSide::Right).map(person).collect();
    let left = worn(MarkerSide::Left).map(|name| person_of(name).unwrap_or_default());
    let mut people: Vec<&str> = left
        .filter(|left| right.iter().any(|right| right == left))
        .collect();
    people.sort_unstable();
    people.dedup();
    people
}

/// Returns the columns of a file's markers without those of strangers, whose prefixes have a marker
/// on a place that the only person's own markers have.
fn columns_of_one(markers: &Markers) -> Result<Vec<usize>, String> {
    let people = people(markers);
    let person = match people.as_slice() {
        [] => return Ok((0..markers.names.len()).collect()),
        [person] => *person,
        people => {
            return Err(format!(
                "several people, expected the name of one; there are: {}",
                people.join(", ")
            ));
        }
    };
    let prefix = |column: &usize| person_of(&markers.names[*column]).unwrap_or_default();
    let place = |column: &usize| place_of(&markers.names[*column]);
    let all = 0..markers.names.len();
    let (own, others): (Vec<usize>, Vec<usize>) =
        all.clone().partition(|column| prefix(column) == person);
    let is_taken = |column: &&usize| {
        let taken = place(column);
        taken.is_some() && own.iter().any(|own| place(own) == taken)
    };
    let strangers: Vec<&str> = others.iter().filter(is_taken).map(prefix).collect();
    Ok(all
        .filter(|column| !strangers.contains(&prefix(column)))
        .collect())
}

impl Marks {
    /// Picks the markers whose names are known. A second knee or ankle marker of the same name
    /// (names cut to four letters) is the medial one.
    ///
    /// # Errors
    /// If no name is known, or there are several people.
    pub(super) fn find(markers: &Markers, warnings: &mut Vec<String>) -> Result<Self, String> {
        let mut all: Vec<Mark> = Vec::new();
        for column in columns_of_one(markers)? {
            let name = &markers.names[column];
            let Some((mut site, side)) = place_of(name) else {
                continue;
            };
            let track: Vec<Option<DVec3>> = markers
                .frames
                .iter()
                .map(|frame| {
                    frame
                        .get(column)
                        .copied()
                        .flatten()
                        .filter(|p| p.is_finite())
                })
                .collect();
            if track.iter().all(Option::is_none) {
                continue;
            }
            let bare = |name: &str| name.rsplit(':').next().unwrap_or(name).to_lowercase();
            if let Some(first) = all.iter().find(|mark| bare(&mark.name) == bare(name)) {
                let is_same_person = person_of(&first.name) == person_of(name);
                site = match site {
                    Site::Knee if is_same_person => Site::KneeMedial,
                    Site::Ankle if is_same_person => Site::AnkleMedial,
                    _ => {
                        warnings.push(format!("marker {name} occurs twice: the first is used"));
                        continue;
                    }
                };
            }
            all.push(Mark {
                name: name.clone(),
                site,
                side,
                track,
            });
        }
        if all.is_empty() {
            let some: Vec<&str> = markers.names.iter().take(6).map(String::as_str).collect();
            return Err(format!(
                "no marker has a known name: expected Plug-in Gait's (LASI, RASI, LKNE, LANK, ..) or OpenSim's, found {}",
                some.join(", ")
            ));
        }
        Ok(Self {
            sample_rate_hz: markers.sample_rate_hz,
            frames: markers.frames.len(),
            all,
        })
    }

    /// Returns the first marker of a place.
    pub(super) fn get(&self, site: Site, side: MarkerSide) -> Option<&Mark> {
        self.all
            .iter()
            .find(|mark| mark.site == site && mark.side == side)
    }

    /// Returns whether a place has a marker.
    pub(super) fn has(&self, site: Site, side: MarkerSide) -> bool {
        self.get(site, side).is_some()
    }

    /// Returns the position of a place in a frame.
    pub(super) fn at(&self, site: Site, side: MarkerSide, frame: usize) -> Option<DVec3> {
        self.get(site, side)?.track.get(frame).copied().flatten()
    }

    /// Checks that the set has the markers of the pelvis and of both ankles.
    ///
    /// # Errors
    /// Names the missing marker, if no other can stand in for it.
    pub(super) fn require(&self) -> Result<(), String> {
        let lacks = |site, side, names: &str| {
            Err(format!(
                "no marker for the {} ({names}): no name in the file matches",
                MarkerPlace(site, side)
            ))
        };
        for side in MarkerSide::BOTH {
            if !self.has(Site::Asis, side) {
                return lacks(Site::Asis, side, "LASI, RASI");
            }
        }
        if !self.has(Site::Sacrum, MarkerSide::Middle)
            && !MarkerSide::BOTH
                .iter()
                .all(|&side| self.has(Site::Psis, side))
        {
            return lacks(Site::Sacrum, MarkerSide::Middle, "SACR, or LPSI and RPSI");
        }
        for side in MarkerSide::BOTH {
            let clusters = |site| self.all.iter().filter(|m| m.body() == (site, side)).count() >= 3;
            let ankle = self.has(Site::Ankle, side)
                || self.has(Site::AnkleCentre, side)
                || (clusters(Segment::Shank) && clusters(Segment::Foot));
            if !ankle {
                return lacks(Site::Ankle, side, "LANK, RANK");
            }
        }
        Ok(())
    }

    /// Rotates the tracks to Y up and converts them to metres. Returns the metres in a source unit.
    ///
    /// # Errors
    /// If no known unit gives human legs, or pelvis and ankles are never seen together.
    pub(super) fn count_in_metres(
        &mut self,
        stated: Option<f64>,
        warnings: &mut Vec<String>,
    ) -> Result<f64, String> {
        let mut legs: Vec<f64> = Vec::new();
        let mut along: [Vec<f64>; 3] = Default::default();
        let low = [Site::Ankle, Site::AnkleCentre, Site::Heel];
        for frame in 0..self.frames {
            let pair = |site| {
                Some((
                    self.at(site, MarkerSide::Left, frame)?,
                    self.at(site, MarkerSide::Right, frame)?,
                ))
            };
            let ankles = low.iter().find_map(|&site| pair(site));
            let (Some((a, b)), Some((c, d))) = (pair(Site::Asis), ankles) else {
                continue;
            };
            let hips = a.midpoint(b);
            let up = hips - c.midpoint(d);
            legs.push(0.5 * (hips.distance(c) + hips.distance(d)));
            for (axis, values) in along.iter_mut().enumerate() {
                values.push(up[axis]);
            }
        }
        if legs.is_empty() {
            return Err(
                "the markers of the pelvis and of both ankles are never seen together".into(),
            );
        }
        let leg = LEG_OF_PELVIS_TO_ANKLE * median(&mut legs);
        let unit_m = choose_unit(leg, stated, UnitFamily::Other, warnings)?;
        let up = nearest_axis(DVec3::from_array(
            along.map(|mut values| median(&mut values)),
        ));
        let turn = DQuat::from_rotation_arc(up, DVec3::Y);
        for point in self
            .all
            .iter_mut()
            .flat_map(|mark| mark.track.iter_mut().flatten())
        {
            *point = turn * *point * unit_m;
        }
        Ok(unit_m)
    }
}

/// Returns the median (the upper of two middle values); 0 for an empty slice.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}
