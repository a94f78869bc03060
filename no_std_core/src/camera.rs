//! Where a silhouette is seen from, and how a figure is fitted into it.

use core::fmt;
use glam::{Vec2, Vec3};

/// A direction from which a walker is seen.
///
/// Azimuth 0 is a camera in front of the walker, 90 on the walker's left (the
/// walker moves to the image's left), 180 behind. Elevation 0 is level, 90
/// straight above; there the image's up is the horizontal direction away from the
/// camera, -(sin azimuth, 0, cos azimuth), so that nothing jumps at 90.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    right: Vec3,
    up: Vec3,
}

/// Why two angles are not a viewpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ViewpointError {
    /// The azimuth is not a finite number of degrees within a million turns.
    Azimuth(f32),
    /// The elevation is not within -90..=90 degrees.
    Elevation(f32),
}

impl fmt::Display for ViewpointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Azimuth(found) => write!(
                f,
                "azimuth {found}: expected degrees within -360000000..=360000000"
            ),
            Self::Elevation(found) => {
                write!(f, "elevation {found}: expected degrees within -90..=90")
            }
        }
    }
}

impl core::error::Error for ViewpointError {}

impl Viewpoint {
    /// A viewpoint from degrees. Multiples of 90 degrees are exact, and azimuths
    /// a whole turn apart are the same viewpoint.
    ///
    /// # Errors
    /// For angles that are not finite or out of range.
    pub fn from_degrees(azimuth_deg: f32, elevation_deg: f32) -> Result<Self, ViewpointError> {
        // A NaN fails both comparisons.
        if !(-3.6e8..=3.6e8).contains(&azimuth_deg) {
            return Err(ViewpointError::Azimuth(azimuth_deg));
        }
        if !(-90.0..=90.0).contains(&elevation_deg) {
            return Err(ViewpointError::Elevation(elevation_deg));
        }
        let (sin_a, cos_a) = sin_cos_degrees(azimuth_deg);
        let (sin_e, cos_e) = sin_cos_degrees(elevation_deg);
        Ok(Self {
            right: Vec3::new(cos_a, 0.0, -sin_a),
            up: Vec3::new(-sin_a * sin_e, cos_e, -cos_a * sin_e),
        })
    }

    /// The direction of the image's right, a unit vector.
    #[must_use]
    pub const fn right(&self) -> Vec3 {
        self.right
    }

    /// The direction of the image's up, a unit vector.
    #[must_use]
    pub const fn up(&self) -> Vec3 {
        self.up
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90.
fn sin_cos_degrees(degrees: f32) -> (f32, f32) {
    // The remainder is exact; 360 times a rounded quotient is not beyond 372,000 turns.
    let remainder = libm::fmodf(degrees, 360.0);
    let turned = if remainder < 0.0 {
        remainder + 360.0
    } else {
        remainder
    };
    let quarter = libm::roundf(turned / 90.0);
    let (sin, cos) = libm::sincosf((turned - 90.0 * quarter).to_radians());
    #[expect(clippy::cast_possible_truncation, reason = "0 to 4")]
    match quarter as i32 {
        1 => (cos, -sin),
        2 => (-sin, -cos),
        3 => (-cos, sin),
        _ => (sin, cos),
    }
}

/// An orthographic camera: parallel rays, metres in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    viewpoint: Viewpoint,
}

impl Camera {
    /// A camera that looks along `viewpoint`.
    #[must_use]
    pub const fn orthographic(viewpoint: Viewpoint) -> Self {
        Self { viewpoint }
    }

    /// Where `point` appears: metres to the right and metres up.
    #[must_use]
    pub fn project(&self, point: Vec3) -> Vec2 {
        Vec2::new(
            self.viewpoint.right.dot(point),
            self.viewpoint.up.dot(point),
        )
    }
}

/// From image metres to the pixels of a window: one scale, y turned downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Pixels a metre.
    pub scale: f32,
    /// The image point, metres, that falls on column `column`, row 0.
    pub origin: Vec2,
    /// Column on which the origin falls.
    pub column: f32,
}

impl Placement {
    /// The pixel coordinates of an image point: x to the right, y down, pixel
    /// `(c, r)` covers `c..c+1` by `r..r+1`.
    #[must_use]
    pub fn place(&self, point: Vec2) -> Vec2 {
        Vec2::new(
            (point.x - self.origin.x) * self.scale + self.column,
            (self.origin.y - point.y) * self.scale,
        )
    }

    /// The same placement seen from a window `columns` further right.
    #[must_use]
    pub fn shifted(&self, columns: f32) -> Self {
        Self {
            column: self.column - columns,
            ..*self
        }
    }
}

/// The rectangle that a figure takes in the image, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Leftmost and lowest.
    pub min: Vec2,
    /// Rightmost and highest.
    pub max: Vec2,
}

impl Extent {
    /// The extent of projected `points`; `None` without any, or if one is not finite.
    pub fn of(points: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        let mut extent: Option<Self> = None;
        for point in points {
            if !point.is_finite() {
                return None;
            }
            let (min, max) = extent.map_or((point, point), |e| (e.min, e.max));
            extent = Some(Self {
                min: min.min(point),
                max: max.max(point),
            });
        }
        extent
    }

    /// Width, metres.
    #[must_use]
    pub fn width(&self) -> f32 {
        self.max.x - self.min.x
    }

    /// Height, metres.
    #[must_use]
    pub fn height(&self) -> f32 {
        self.max.y - self.min.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(azimuth: f32, elevation: f32) -> Camera {
        Camera::orthographic(Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint"))
    }

    #[test]
    fn from_the_front_the_walkers_left_is_on_the_right() {
        assert_eq!(camera(0.0, 0.0).project(Vec3::X), Vec2::X);
        assert_eq!(camera(0.0, 0.0).project(Vec3::Y), Vec2::Y);
        assert_eq!(camera(0.0, 0.0).project(Vec3::Z), Vec2::ZERO);
    }

    #[test]
    fn from_the_walkers_left_the_walker_moves_to_the_left() {
        assert_eq!(camera(90.0, 0.0).project(Vec3::Z), -Vec2::X);
        assert_eq!(camera(270.0, 0.0).project(Vec3::Z), Vec2::X);
    }

    #[test]
    fn from_behind_left_is_left() {
        assert_eq!(camera(180.0, 0.0).project(Vec3::X), -Vec2::X);
    }

    #[test]
    fn from_above_up_is_away_from_the_camera() {
        assert_eq!(camera(0.0, 90.0).project(-Vec3::Z), Vec2::Y);
        assert_eq!(camera(90.0, 90.0).project(-Vec3::X), Vec2::Y);
        assert_eq!(camera(0.0, 90.0).project(Vec3::Y), Vec2::ZERO);
        let (near, above) = (camera(30.0, 89.999), camera(30.0, 90.0));
        let difference = near.project(Vec3::ONE) - above.project(Vec3::ONE);
        assert!(difference.length() < 1e-4);
    }

    #[test]
    fn whole_turns_change_nothing() {
        for azimuth in [-355.0, 365.0, 3_605.0] {
            assert_eq!(camera(azimuth, 35.0), camera(5.0, 35.0));
        }
    }

    #[test]
    fn sines_and_cosines_agree_with_f64_everywhere() {
        for tenth in -9_000..9_000 {
            let degrees = f64::from(tenth) / 10.0;
            #[expect(clippy::cast_possible_truncation, reason = "the value under test")]
            let (sin, cos) = sin_cos_degrees(degrees as f32);
            let radians = degrees.to_radians();
            assert!(
                (f64::from(sin) - libm::sin(radians)).abs() < 3e-6,
                "{degrees}"
            );
            assert!(
                (f64::from(cos) - libm::cos(radians)).abs() < 3e-6,
                "{degrees}"
            );
        }
    }

    #[test]
    fn what_is_no_viewpoint_is_a_typed_error() {
        use ViewpointError::{Azimuth, Elevation};
        assert!(matches!(
            Viewpoint::from_degrees(f32::NAN, 0.0),
            Err(Azimuth(_))
        ));
        assert_eq!(
            Viewpoint::from_degrees(f32::INFINITY, 0.0),
            Err(Azimuth(f32::INFINITY))
        );
        assert_eq!(Viewpoint::from_degrees(0.0, 90.1), Err(Elevation(90.1)));
        assert!(Viewpoint::from_degrees(0.0, -90.0).is_ok());
    }
}
