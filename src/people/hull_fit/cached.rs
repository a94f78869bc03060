//! The cache of fitted hulls: a fit takes a minute of processor time, and is the same each time.

use super::fitted_body;
use crate::error::Result;
use crate::files::cache::{Cache, CacheKey};
use crate::import::Motion;
use crate::people::{Body, BodyHull, HullFit};
use edgegait_core::skeleton::{JOINTS, Joint};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Revision of the fit, to be raised with each change of its results.
const REVISION: u32 = 1;
const KIND: &str = "hulls";

/// A fitted body, with numbers as their bits, since JSON numbers can come back one unit off.
#[derive(Serialize, Deserialize)]
struct KeptBody {
    offsets: Vec<[u64; 3]>,
    hulls: Vec<(usize, Vec<[u64; 3]>)>,
    jaccard: u64,
    frontier: Vec<(usize, u64)>,
}

/// Returns the result of [`fitted_body`], from the cache if it is there, and whether it was.
///
/// # Errors
/// As [`fitted_body`]. A failure to write the cache is no error.
pub(crate) fn kept_body(
    mesh: &Motion,
    points: usize,
    seed: u64,
    cache: &Cache,
    progress: &(dyn Fn() -> Result<()> + Sync),
) -> Result<(Body, bool)> {
    let key = key(mesh, points, seed);
    let kept = cache.read(KIND, &key);
    let kept = kept.and_then(|bytes| serde_json::from_slice::<KeptBody>(&bytes).ok());
    if let Some(body) = kept.and_then(KeptBody::body) {
        return Ok((body, true));
    }
    let body = fitted_body(mesh, points, seed, progress)?;
    if let Some(kept) = KeptBody::from_body(&body) {
        // If this fails, the body is fitted again the next time.
        let _ = cache.keep(KIND, &key, &serde_json::to_vec(&kept)?);
    }
    Ok((body, false))
}

/// Returns the key of everything that a fit reads. Rust writes floats so that they read back the
/// same.
fn key(mesh: &Motion, points: usize, seed: u64) -> CacheKey {
    let Motion {
        format,
        joints,
        sample_rate_hz: _,
        frames,
        unit_m,
        skin,
        warnings: _,
    } = mesh;
    let shape = format!("{format:?} {joints:?} {frames:?} {unit_m:?} {skin:?}");
    let asked = format!("{REVISION} {points} {seed}");
    CacheKey::hash(&[asked.as_bytes(), shape.as_bytes()])
}

impl KeptBody {
    /// Returns the kept form of a body; `None` if it has more than a fit gives.
    fn from_body(body: &Body) -> Option<Self> {
        let bits = |at: &DVec3| at.to_array().map(f64::to_bits);
        let fit = body.fit.as_ref()?;
        if !body.draped.is_empty() || body.clothes.is_some() {
            return None;
        }
        let hull = |hull: &BodyHull| (hull.joint.index(), hull.points.iter().map(bits).collect());
        let level = |&(points, jaccard): &(usize, f64)| (points, jaccard.to_bits());
        Some(Self {
            offsets: body.offsets.iter().map(bits).collect(),
            hulls: body.hulls.iter().map(hull).collect(),
            jaccard: fit.jaccard.to_bits(),
            frontier: fit.frontier.iter().map(level).collect(),
        })
    }

    /// Returns the body; `None` if the kept form is broken.
    fn body(self) -> Option<Body> {
        let point = |bits: [u64; 3]| {
            let at = DVec3::from_array(bits.map(f64::from_bits));
            at.is_finite().then_some(at)
        };
        let offsets: Option<Vec<DVec3>> = self.offsets.into_iter().map(point).collect();
        let offsets: [DVec3; JOINTS] = offsets?.try_into().ok()?;
        let hulls = self.hulls.into_iter().map(|(joint, points)| {
            Some(BodyHull {
                joint: Joint::ALL.get(joint).copied()?,
                points: points.into_iter().map(point).collect::<Option<_>>()?,
            })
        });
        let frontier = self.frontier.into_iter();
        Some(Body {
            offsets,
            hulls: hulls.collect::<Option<_>>()?,
            draped: Vec::new(),
            clothes: None,
            fit: Some(HullFit {
                jaccard: f64::from_bits(self.jaccard),
                frontier: frontier
                    .map(|(points, bits)| (points, f64::from_bits(bits)))
                    .collect(),
            }),
        })
    }
}
