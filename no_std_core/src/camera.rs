//! Viewpoints, cameras, and how a figure is framed in the image.

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
    toward: Vec3,
}

/// The reason why two angles are not a viewpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
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
    /// Makes a viewpoint from degrees. Multiples of 90 degrees are exact, and azimuths a whole turn
    /// apart give the same viewpoint.
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
            toward: Vec3::new(sin_a * cos_e, sin_e, cos_a * cos_e),
        })
    }

    /// Rolls the camera about its optical axis: clockwise as seen from behind it, so that the
    /// figure turns counterclockwise in the image. Multiples of 90 degrees are exact, and whole
    /// turns change nothing.
    ///
    /// With an angle that is not finite, every figure is rejected as not finite.
    #[must_use]
    pub fn rolled(self, degrees: f32) -> Self {
        let (sin, cos) = sin_cos_degrees(degrees);
        if (sin, cos) == (0.0, 1.0) {
            return self;
        }
        let Self { right, up, toward } = self;
        Self {
            right: cos * right - sin * up,
            up: cos * up + sin * right,
            toward,
        }
    }

    /// Returns the direction of the image's right, a unit vector.
    #[must_use]
    pub const fn right(&self) -> Vec3 {
        self.right
    }

    /// Returns the direction of the image's up, a unit vector.
    #[must_use]
    pub const fn up(&self) -> Vec3 {
        self.up
    }

    /// Returns the direction from the walker to the camera, a unit vector.
    #[must_use]
    pub const fn toward(&self) -> Vec3 {
        self.toward
    }
}

/// Returns the sine and cosine of an angle in degrees, exact at multiples of 90.
fn sin_cos_degrees(degrees: f32) -> (f32, f32) {
    // The remainder is exact. Subtracting 360 times a rounded quotient is not, beyond 372,000
    // turns.
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

/// The minimum distance of a point in front of a perspective camera's eye, metres.
pub const NEAR_M: f32 = 0.1;

/// The kind of projection.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rays {
    /// Parallel rays.
    Orthographic,
    /// Rays from an eye at this distance from the point that it aims at.
    Perspective { aim: Vec3, distance_m: f32 },
}

/// A camera: a viewpoint, with parallel rays or in perspective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    viewpoint: Viewpoint,
    lens: Rays,
}

/// The reason why a camera cannot be made.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum CameraError {
    /// The distance is not within 0.1..=1,000,000 m.
    Distance(f32),
    /// The aim is not a finite point.
    Aim(Vec3),
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Distance(found) => {
                write!(
                    f,
                    "camera distance {found}: expected metres within 0.1..=1000000"
                )
            }
            Self::Aim(found) => write!(f, "camera aim {found}: expected finite metres"),
        }
    }
}

impl core::error::Error for CameraError {}

impl Camera {
    /// Makes a camera with parallel rays that looks along `viewpoint`.
    #[must_use]
    pub const fn orthographic(viewpoint: Viewpoint) -> Self {
        Self {
            viewpoint,
            lens: Rays::Orthographic,
        }
    }

    /// Makes a camera whose eye is `distance_m` from `aim` in the direction of `viewpoint` and
    /// looks at `aim`.
    ///
    /// # Errors
    /// For a distance out of range or an aim that is not finite.
    pub fn perspective(
        viewpoint: Viewpoint,
        aim: Vec3,
        distance_m: f32,
    ) -> Result<Self, CameraError> {
        // A NaN fails both comparisons.
        if !(0.1..=1e6).contains(&distance_m) {
            return Err(CameraError::Distance(distance_m));
        }
        if !aim.is_finite() {
            return Err(CameraError::Aim(aim));
        }
        Ok(Self {
            viewpoint,
            lens: Rays::Perspective { aim, distance_m },
        })
    }

    /// Returns the viewpoint.
    #[must_use]
    pub const fn viewpoint(&self) -> Viewpoint {
        self.viewpoint
    }

    /// Returns the aim and the eye's distance from it, metres; `None` with parallel rays.
    pub(crate) const fn eye(&self) -> Option<(Vec3, f32)> {
        match self.lens {
            Rays::Orthographic => None,
            Rays::Perspective { aim, distance_m } => Some((aim, distance_m)),
        }
    }

    /// Returns how far `point` is in front of the eye, metres: infinity for parallel rays.
    #[must_use]
    pub fn depth_m(&self, point: Vec3) -> f32 {
        match self.lens {
            Rays::Orthographic => f32::INFINITY,
            Rays::Perspective { aim, distance_m } => {
                distance_m - self.viewpoint.toward.dot(point - aim)
            }
        }
    }

    /// Returns where `point` appears: metres to the right and metres up, from the origin with
    /// parallel rays, from the aim in perspective. In perspective they are metres in the plane
    /// through the aim: whatever is nearer appears larger.
    ///
    /// # Guarantees
    /// The result is meaningful only for points with a depth of at least [`NEAR_M`].
    #[must_use]
    #[inline]
    pub fn project(&self, point: Vec3) -> Vec2 {
        let Viewpoint { right, up, .. } = self.viewpoint;
        match self.lens {
            Rays::Orthographic => Vec2::new(right.dot(point), up.dot(point)),
            Rays::Perspective { aim, distance_m } => {
                let from_aim = point - aim;
                let growth = distance_m / self.depth_m(point);
                Vec2::new(right.dot(from_aim) * growth, up.dot(from_aim) * growth)
            }
        }
    }
}

/// The rule by which a figure is placed and scaled in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Framing {
    /// Scaled to fill all rows, and shifted by whole columns so that its centroid lands in the
    /// middle. The part that the columns cut off is reported.
    Height,
    /// Stretched so that its bounding box fills the image: a scale for each axis, nothing is cut
    /// off.
    Box,
    /// One fixed scale, independent of the figure: nothing is measured or shifted. Use the same one
    /// for all frames of a walk or of a fixed sensor.
    Fixed {
        /// The point that appears in the middle of the image, metres.
        centre: Vec3,
        /// Pixels for each metre of the image, above 0.
        pixels_per_metre: f32,
    },
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

    fn viewpoint(azimuth: f32, elevation: f32) -> Viewpoint {
        Viewpoint::from_degrees(azimuth, elevation).expect("a viewpoint")
    }

    fn perspective(azimuth: f32, elevation: f32, aim: Vec3, distance_m: f32) -> Camera {
        Camera::perspective(viewpoint(azimuth, elevation), aim, distance_m).expect("a camera")
    }

    #[test]
    fn the_camera_stands_where_the_viewpoint_says() {
        for (azimuth, elevation, toward) in [
            (0.0, 0.0, Vec3::Z),
            (90.0, 0.0, Vec3::X),
            (180.0, 0.0, -Vec3::Z),
            (-90.0, 0.0, -Vec3::X),
            (35.0, 90.0, Vec3::Y),
            (35.0, -90.0, -Vec3::Y),
        ] {
            assert_eq!(viewpoint(azimuth, elevation).toward(), toward);
        }
        let oblique = viewpoint(33.0, 47.0);
        let expected = oblique.right().cross(oblique.up());
        assert!((oblique.toward() - expected).length() < 1e-6);
        for azimuth in [360.0, -360.0] {
            assert_eq!(viewpoint(azimuth, 20.0), viewpoint(0.0, 20.0));
        }
    }

    #[test]
    fn a_point_a_metre_nearer_at_four_metres_appears_four_thirds_as_far_out() {
        let front = perspective(0.0, 0.0, Vec3::new(0.0, 1.0, 0.0), 4.0);
        let at = |z| front.project(Vec3::new(0.3, 1.6, z));
        assert!((at(0.0) - Vec2::new(0.3, 0.6)).length() < 1e-6);
        assert!((at(1.0) - Vec2::new(0.4, 0.8)).length() < 1e-6);
        // 4 m behind the aim: half as far out.
        assert!((at(-4.0) - Vec2::new(0.15, 0.3)).length() < 1e-6);
        assert_eq!(front.depth_m(Vec3::new(0.3, 1.6, 1.0)), 3.0);
        assert_eq!(camera(0.0, 0.0).depth_m(Vec3::splat(7.0)), f32::INFINITY);
        // From above, higher points are nearer.
        let above = perspective(0.0, 90.0, Vec3::ZERO, 4.0);
        assert!((above.project(Vec3::new(0.3, 2.0, 0.0)) - Vec2::new(0.6, 0.0)).length() < 1e-6);
    }

    #[test]
    fn from_a_kilometre_perspective_is_orthographic() {
        for (azimuth, elevation) in [(0.0, 0.0), (90.0, 0.0), (37.0, 41.0), (200.0, 90.0)] {
            let far = perspective(azimuth, elevation, Vec3::ZERO, 1_000.0);
            for point in [Vec3::new(0.5, 0.9, -0.4), Vec3::new(-0.3, 0.2, 0.7)] {
                let difference = far.project(point) - camera(azimuth, elevation).project(point);
                assert!(
                    difference.length() < 1e-3,
                    "{azimuth} {elevation} {difference}"
                );
            }
        }
    }

    #[test]
    fn nothing_jumps_straight_above() {
        let aim = Vec3::new(0.1, 0.9, 0.2);
        for azimuth in [0.0, 90.0, 123.0] {
            let (near, above) = (
                perspective(azimuth, 89.999, aim, 4.0),
                perspective(azimuth, 90.0, aim, 4.0),
            );
            let difference = near.project(Vec3::ONE) - above.project(Vec3::ONE);
            assert!(difference.length() < 1e-4, "{azimuth}: {difference}");
        }
    }

    #[test]
    fn what_is_no_camera_is_a_typed_error() {
        let made = |aim, distance_m| Camera::perspective(viewpoint(0.0, 0.0), aim, distance_m);
        for bad in [0.0, -4.0, 0.099, 1.1e6, f32::INFINITY] {
            assert_eq!(made(Vec3::ZERO, bad), Err(CameraError::Distance(bad)));
        }
        assert!(matches!(
            made(Vec3::ZERO, f32::NAN),
            Err(CameraError::Distance(_))
        ));
        let nowhere = Vec3::new(0.0, f32::INFINITY, 0.0);
        assert_eq!(made(nowhere, 4.0), Err(CameraError::Aim(nowhere)));
        assert!(made(Vec3::ZERO, 0.1).is_ok() && made(Vec3::ZERO, 1e6).is_ok());
    }
}
