//! Flags that choose the bodies: from measurements, or fitted to a mesh.

use super::args::Common;
use super::cache::CacheArgs;
use super::hints::WithFlags;
use super::keep_going::{KeepGoing, with_hint};
use super::progress::Progress;
use super::values::SexArg;
use crate::error::{Error, Result};
use crate::files::{InputFile, ResultHeader};
use crate::import::{FileContents, Motion, is_gltf, skinned_body};
use crate::people::Body;
use crate::people::hull_fit::{STEPS, USUAL_POINTS, kept_body};
use crate::people::measured::MeasuredPeople;
use crate::people::recorded::{BodyOptions, Recording};
use crate::people::rigging::from_obj;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The flags that choose the bodies.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct BodyArgs {
    /// Stature of the body in metres [default: from the skeleton's segment lengths]
    #[arg(long, value_name = "M")]
    stature_m: Option<f64>,
    /// Mass of the body in kg [default: from the mean body mass index of ANSUR II]
    #[arg(long, value_name = "KG")]
    mass_kg: Option<f64>,
    /// Sex of the body [default: halfway between both]
    #[arg(long, value_name = "SEX")]
    sex: Option<SexArg>,
    /// Measurements of the subjects: a row for each with "subject" and any of stature_m, mass_kg,
    /// sex and body dimensions such as hip_breadth_mm; they take precedence over the three options
    /// above [default: dimensions predicted from stature, mass and sex]
    #[arg(long, value_name = "FILE.csv")]
    bodies: Option<PathBuf>,
    /// Mesh to fit the hulls of all subjects to: skinned (.glb, .gltf), or standing with the arms
    /// away from the trunk (.obj) [default: the mesh of each file that has one]
    #[arg(long, value_name = "MESH", conflicts_with_all = ["stature_m", "bodies"])]
    body: Option<PathBuf>,
    /// Skeleton of the .obj file: a file with the mesh's rest pose [default: estimated from the
    /// mesh]
    #[arg(long, value_name = "FILE", requires = "body")]
    skeleton: Option<PathBuf>,
    #[command(flatten)]
    cache: CacheArgs,
}

impl BodyArgs {
    /// Returns the files that the flags name.
    pub(super) fn files(&self) -> impl Iterator<Item = PathBuf> {
        let files = [&self.bodies, &self.body, &self.skeleton];
        files.into_iter().flatten().cloned()
    }

    /// Returns the measured people, and warnings about fields that count as not measured.
    ///
    /// # Errors
    /// As [`MeasuredPeople::read_usable`], and for unusable values unless it is to keep going.
    pub(super) fn measured(&self, keep_going: KeepGoing) -> Result<(MeasuredPeople, Vec<String>)> {
        let Some(path) = &self.bodies else {
            return Ok((MeasuredPeople::default(), Vec::new()));
        };
        let (people, unusable) = MeasuredPeople::read_usable(path)?;
        if keep_going.is_given() {
            let warning = |error: &Error| format!("{}: treated as not measured", WithFlags(error));
            return Ok((people, unusable.iter().map(warning).collect()));
        }
        let first = unusable.into_iter().next();
        first.map_or(Ok((people, Vec::new())), |error| {
            let hint = "--keep-going treats it as not measured";
            Err(with_hint(error, hint))
        })
    }

    /// Returns the bodies of these recordings, with hulls fitted to meshes with this number of
    /// points, if given, and the seed of `common`. Input files and warnings go into the header. With
    /// `--keep-going`, recordings whose own mesh has no figure are removed.
    ///
    /// # Errors
    /// For meshes that cannot be read or have no figure.
    pub(super) fn options(
        &self,
        recordings: &mut Vec<Recording>,
        measured: MeasuredPeople,
        points: Option<usize>,
        common: &Common,
        keep_going: KeepGoing,
        header: &mut ResultHeader,
    ) -> Result<BodyOptions> {
        if let Some(path) = &self.bodies {
            header.inputs.push(InputFile::read(path)?);
            let mut names: Vec<&str> = recordings.iter().map(|it| it.subject.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            let warnings = measured.warnings(&names, self.stature_m.is_some());
            header.warnings.extend(warnings);
        }
        let cache = self.cache.cache();
        let fit = |path: &Path, mesh: &Motion| {
            let progress = Progress::new(common, ("fitting the hull in", "steps"), STEPS);
            let points = points.unwrap_or(USUAL_POINTS);
            let found = kept_body(mesh, points, common.seed, &cache, &|| progress.step());
            found.map(|(body, _)| body).map_err(|error| match error {
                Error::Mesh(problem) => Error::input(path, problem),
                other => other,
            })
        };
        let mut given: BTreeMap<String, Body> = BTreeMap::new();
        if let Some(path) = &self.body {
            for path in [Some(path), self.skeleton.as_ref()].into_iter().flatten() {
                header.inputs.push(InputFile::read(path)?);
            }
            let body = fit(path, &self.mesh(path)?)?;
            for recording in recordings {
                given.insert(recording.subject.clone(), body.clone());
            }
        } else if self.stature_m.is_none() {
            let (all, mut refused) = (recordings.len(), Vec::new());
            recordings.retain(|recording| {
                let subject = &recording.subject;
                let is_over = !refused.is_empty() && !keep_going.is_given();
                let is_done = is_over || given.contains_key(subject);
                let Some(mesh) = recording.mesh.as_ref().filter(|_| !is_done) else {
                    return true;
                };
                let fitted = fit(&recording.path, mesh).map_err(|error| refused.push(error));
                fitted
                    .map(|body| given.insert(subject.clone(), body))
                    .is_ok()
            });
            let left_out = keep_going.leave_out(refused, all, "files", "imported")?;
            header.warnings.extend(left_out);
        }
        Ok(BodyOptions {
            stature_m: self.stature_m,
            mass_kg: self.mass_kg,
            sex: self.sex.map(SexArg::sex),
            measured,
            given,
        })
    }

    /// Reads the mesh of `--body`, with a skeleton.
    fn mesh(&self, path: &Path) -> Result<Motion> {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        match (is_gltf(path), extension == "obj", &self.skeleton) {
            (true, _, None) => skinned_body(path),
            (true, _, Some(_)) => Err(Error::Usage(
                "--skeleton: a .glb or .gltf file has its own skeleton".into(),
            )),
            (_, true, skeleton) => {
                let skeleton = skeleton.as_deref().map(rest).transpose()?;
                from_obj(path, skeleton.as_ref())
            }
            _ => Err(Error::input(path, "expected a mesh: .glb, .gltf or .obj")),
        }
    }
}

/// Reads a skeleton for a mesh.
fn rest(path: &Path) -> Result<Motion> {
    if is_gltf(path) {
        return skinned_body(path);
    }
    match FileContents::read(path)? {
        FileContents::Motion(motion) => Ok(motion),
        FileContents::Markers(_) => Err(Error::input(path, "expected a skeleton, found markers")),
    }
}
