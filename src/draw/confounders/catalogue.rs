//! The list of confounders: names, classes, and what each does at strength 1.

use serde::Serialize;

/// The class of a confounder, after Charalambous & Bharath (BMVC 2016, section 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The scene: floor, light, shadows, occluders, segmentation faults.
    Environment,
    /// The camera: viewpoint, lens, exposure, resolution, frames.
    Imaging,
    /// The walker: body, gait, clothes, loads.
    Appearance,
}

impl Class {
    /// Returns the name of the class in lists and results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Environment => "environment",
            Self::Imaging => "imaging",
            Self::Appearance => "appearance",
        }
    }
}

/// The stage of rendering at which a confounder acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The body's hulls, before the body is posed.
    Body,
    /// The poses.
    Motion,
    /// The choice of frames.
    Time,
    /// The camera.
    Camera,
    /// The silhouette, before it is framed.
    Image,
}

/// The physical unit of a confounder whose strength is proportional to a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoseUnit {
    /// The unit's symbol in conditions, such as `deg`.
    pub name: &'static str,
    /// The amount at strength 1.
    pub full: f64,
}

/// The catalogue's entry of a confounder, which makes the same walk look different.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confounder {
    /// The confounder that the entry describes.
    pub kind: ConfounderKind,
    /// The name of the confounder in conditions and results.
    pub name: &'static str,
    /// The class of what varies.
    pub class: Class,
    /// The stage of rendering at which the confounder acts.
    pub stage: Stage,
    /// Whether there is an opposite: strengths start at -1, otherwise at 0.
    pub is_signed: bool,
    /// The physical unit of the strength, if there is one.
    pub unit: Option<DoseUnit>,
    /// A description of the confounder at strength 1.
    pub at_full: &'static str,
}

/// Declares [`ConfounderKind`] and [`CATALOGUE`].
macro_rules! confounders {
    ($($kind:ident $name:literal $class:ident $stage:ident $signed:literal $unit:expr, $full:literal;)*) => {
        /// A confounder, in the order of application. Each is described at strength 1.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum ConfounderKind {
            $(#[doc = $full] $kind,)*
        }

        /// All confounders, in the order in which they are applied.
        pub const CATALOGUE: [Confounder; [$(stringify!($kind)),*].len()] = [
            $(Confounder {
                kind: ConfounderKind::$kind,
                name: $name,
                class: Class::$class,
                stage: Stage::$stage,
                is_signed: $signed,
                unit: $unit,
                at_full: $full,
            },)*
        ];
    };
}

const fn unit(full: f64, name: &'static str) -> Option<DoseUnit> {
    Some(DoseUnit { name, full })
}

confounders! {
    BodyMass "body-mass" Appearance Body true None, "1.3 times the mass at the same stature (-1: divided by 1.3)";
    Build "build" Appearance Body true unit(2.0, "sd"), "two residual standard deviations broader at the same mass (-1: slenderer)";
    Age "age" Appearance Body false None, "80 years old: shorter trunk, wider waist, stoop, shorter steps";
    WideTrousers "wide-trousers" Appearance Body false None, "legs 1 cm wider all around at the hips, 5.5 cm at the ankles";
    Shoes "shoes" Appearance Body false None, "soles of 2 cm, heels of 3.5 cm; shoes reach 2.5 cm beyond the toes";
    Skirt "skirt" Appearance Body false None, "a straight skirt that covers nine tenths of the legs, taut between them; strides shorter by a fifth";
    Coat "coat" Appearance Body false None, "a closed coat, 4 cm thick, from the neck to above the knees";
    OpenCoat "open-coat" Appearance Body false None, "an open coat, 3 cm thick, with tails beside and behind the thighs, 8 cm away";
    DownJacket "down-jacket" Appearance Body false None, "a jacket, 3.8 cm thick, from the neck to half of the thighs";
    Hair "hair" Appearance Body false None, "full hair, 3 cm thick, down to the shoulder blades";
    Hood "hood" Appearance Body false None, "a hood 3 cm away from head and neck; the face is free";
    Hat "hat" Appearance Body false None, "a brim of 7 cm and a crown 5 cm above the head";
    Backpack "backpack" Appearance Body false None, "32 x 46 x 20 cm on the back, and a lean of 10 degrees";
    ShoulderBag "shoulder-bag" Appearance Body false None, "40 x 34 x 12 cm behind the left hip";
    Suitcase "suitcase" Appearance Body false None, "55 x 40 x 20 cm in the right hand; the arm hangs";
    Umbrella "umbrella" Appearance Body false None, "1 m wide, above the head, in the right hand";
    CarriedBox "carried-box" Appearance Body false None, "40 x 30 x 32 cm before the belly, in both hands";
    Stroller "stroller" Appearance Body false None, "70 cm long and 50 cm wide, ahead of the walker, both hands at its bar";
    Speed "speed" Appearance Motion true None, "1.5 times as fast (-1: two thirds), strides longer by 1.5^0.42";
    ArmStill "arm-still" Appearance Motion false None, "the right arm does not swing";
    HandsInPockets "hands-in-pockets" Appearance Motion false None, "both hands in the pockets";
    Phone "phone" Appearance Motion false None, "the right hand at the ear";
    AsymmetricGait "asymmetric-gait" Appearance Motion false None, "a limp: the right hip keeps 60 % of its swing, the trunk tips by 10 degrees";
    Slope "slope" Environment Motion true unit(20.0, "deg"), "20 degrees up (-1: down)";
    FrameRate "frame-rate" Imaging Time false None, "a tenth of the frames; each is repeated until the next one";
    DroppedFrames "dropped-frames" Imaging Time false unit(90.0, "%"), "90 % of the frames lost; the previous frame is repeated";
    Azimuth "azimuth" Imaging Camera true unit(30.0, "deg"), "the camera 30 degrees further around the walker";
    Elevation "elevation" Imaging Camera true unit(30.0, "deg"), "the camera 30 degrees higher, at most vertically above";
    Roll "roll" Imaging Camera true unit(20.0, "deg"), "the camera turned by 20 degrees about its line of sight";
    Distance "distance" Imaging Camera false None, "the camera 1.5 m away (0: at its own distance, infinite for parallel rays)";
    FocalLength "focal-length" Imaging Camera false None, "a quarter of the focal length: a figure of 150 rows on the sensor shrinks to 38";
    Shadow "shadow" Environment Image false None, "the whole shadow of a sun that is 45 degrees high, ahead of the walker and to the left; a level camera sees none";
    StaticOccluder "static-occluder" Environment Image false None, "a pillar, half a metre thick, that the walker passes behind";
    MovingOccluder "moving-occluder" Environment Image false None, "a person of the same size who crosses in front";
    MotionBlur "motion-blur" Imaging Image false unit(0.125, "s"), "an exposure of 1/8 s by a static camera";
    RadialDistortion "radial-distortion" Imaging Image true None, "k1 = -0.3, k2 = 0.08 (-1: k1 = 0.3), the figure 39 degrees off the axis";
    Resolution "resolution" Imaging Image false None, "a figure of ten rows";
    Light "light" Environment Image false None, "patches without contrast, noise and light from one side, then segmentation";
    Holes "holes" Environment Image false None, "six holes with a quarter of the figure's area, each at its place of the body";
    MissingParts "missing-parts" Environment Image false None, "three neighbouring parts of the body, such as a leg, taken for background";
    MergedBackground "merged-background" Environment Image false None, "three blobs with half of the figure's area joined to it";
    Erosion "erosion" Environment Image false unit(3.0, "cm"), "an outline drawn 3 cm too tight";
    Dilation "dilation" Environment Image false unit(3.0, "cm"), "an outline drawn 3 cm too wide";
    Waver "waver" Environment Image false unit(3.0, "cm"), "an outline that drifts by 3 cm (root mean square) as smoothly as in video";
    FilteredNoise "filtered-noise" Environment Image false unit(30.0, "%"), "what a median of 3x3 leaves of 30 % of the samples in the figure's bounding box flipped";
    SaltAndPepper "salt-and-pepper" Environment Image false unit(10.0, "%"), "10 % of the samples in the figure's bounding box flipped";
}

impl ConfounderKind {
    /// Returns the confounder's entry in [`CATALOGUE`].
    #[must_use]
    pub fn confounder(self) -> &'static Confounder {
        &CATALOGUE[self as usize]
    }
}

/// Returns the confounder of this name.
#[must_use]
pub(crate) fn named(name: &str) -> Option<&'static Confounder> {
    CATALOGUE.iter().find(|confounder| confounder.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_apart_and_kinds_find_their_entry() {
        for (at, confounder) in CATALOGUE.iter().enumerate() {
            assert_eq!(confounder.kind.confounder(), confounder);
            assert_eq!(named(confounder.name), Some(confounder));
            let known = |c: char| c.is_ascii_lowercase() || c == '-';
            assert!(confounder.name.chars().all(known), "{}", confounder.name);
            assert!(
                CATALOGUE[..at]
                    .iter()
                    .all(|other| other.stage <= confounder.stage)
            );
        }
        assert_eq!(named("fog"), None);
    }
}
