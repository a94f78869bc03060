//! A table from marker names in files to places on the body.
//!
//! It knows the names of Plug-in Gait (with CGM2's medial markers and the Oxford foot), CMU's set,
//! OpenSim's two sets, BMClab and BTK's samples. Names are compared without case, without a prefix
//! (`Anna:LASI`) and without dots, spaces, hyphens and underscores.

use std::fmt;

/// A side of the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MarkerSide {
    Left,
    Right,
    Middle,
}

impl MarkerSide {
    /// The two sides, left first.
    pub(super) const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// Returns 1 where lateral is +X (the walker's left), -1 on the right.
    pub(super) const fn sign(self) -> f64 {
        match self {
            Self::Right => -1.0,
            Self::Left | Self::Middle => 1.0,
        }
    }
}

/// A rigid segment of the body that carries markers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Segment {
    Pelvis,
    Thigh,
    Shank,
    Foot,
    Thorax,
    Head,
    UpperArm,
    Forearm,
    /// A marker that shares no segment with others: a shoulder, a hand, a joint centre.
    Alone,
}

macro_rules! sites {
    ($($(#[doc = $doc:literal])? $site:ident: $segment:ident, $english:literal, $shape:ident [$($name:literal),*];)*) => {
        /// A place on the body.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(super) enum Site {
            $($(#[doc = $doc])? $site,)*
        }

        impl Site {
            /// Returns the segment that carries the marker.
            pub(super) const fn segment(self) -> Segment {
                match self { $(Self::$site => Segment::$segment,)* }
            }

            const fn english(self) -> &'static str {
                match self { $(Self::$site => $english,)* }
            }
        }

        /// The sites, whether each is paired, and their names in files without the letter of the
        /// side.
        const TABLE: &[(Site, SiteShape, &[&str])] = &[
            $((Site::$site, SiteShape::$shape, &[$($name),*]),)*
        ];
    };
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum SiteShape {
    Paired,
    Single,
}

#[rustfmt::skip]
sites! {
    Asis: Pelvis, "anterior superior iliac spine", Paired ["asi", "asis", "fwt"];
    Psis: Pelvis, "posterior superior iliac spine", Paired ["psi", "psis", "bwt"];
    Sacrum: Pelvis, "sacrum", Single ["sacr", "sac", "sacrum", "vsac", "vsacral", "s2"];
    PelvisCluster: Pelvis, "pelvis", Paired ["iliaccrest", "ic"];
    /// A wand, or a marker on the lateral line of the thigh.
    ThighWand: Thigh, "thigh", Paired ["thi", "thigh"];
    ThighCluster: Thigh, "thigh", Paired ["th1", "th2", "th3", "th4", "thighupper", "thighfront", "thighrear", "f01", "f02", "f03", "f04", "f05"];
    Knee: Thigh, "lateral knee", Paired ["kne", "knee", "lfc", "lfcv", "kneelateral", "latknee", "lknee", "xlatknee", "kl", "lfe", "lep"];
    KneeMedial: Thigh, "medial knee", Paired ["knm", "knein", "knemed", "kneemedial", "kneemed", "medknee", "mknee", "mkne", "mfc", "mfcv", "km", "mfe", "mep"];
    KneeCentre: Alone, "knee joint centre", Paired ["kjc", "feo"];
    /// A wand, or a marker on the lateral line of the shank.
    ShankWand: Shank, "shank", Paired ["tib", "sha", "shank"];
    ShankCluster: Shank, "shank", Paired ["tb1", "tb2", "tb3", "tb4", "sh1", "sh2", "sh3", "sh4", "shankupper", "shankfront", "shankrear", "t01", "t02", "t03", "t04", "t05", "hf", "hfb", "fib", "tt", "tub", "shn"];
    Ankle: Shank, "lateral ankle", Paired ["ank", "ankle", "lmal", "lmalv", "mal", "anklelateral", "latankle", "latmal", "xlatmal", "al"];
    AnkleMedial: Shank, "medial ankle", Paired ["med", "ankin", "ankm", "mank", "mmal", "mmalv", "anklemedial", "anklemed", "medankle", "medmal", "xmedmal", "am"];
    AnkleCentre: Alone, "ankle joint centre", Paired ["ajc", "tio"];
    Heel: Foot, "heel", Paired ["hee", "heel", "cal", "calc", "hel", "h"];
    Toe: Foot, "second toe", Paired ["toe", "mt2", "2mt", "latoe"];
    FirstToe: Foot, "first metatarsal head", Paired ["mt1", "1mt", "d1m", "fm"];
    FifthToe: Foot, "fifth metatarsal head", Paired ["mt5", "5mt", "d5m", "fl"];
    ToeTip: Foot, "toe tip", Paired ["toetip", "hlx", "hallux"];
    FootCluster: Foot, "foot", Paired ["midfootsup", "midfootlat", "toelat", "toemed"];
    C7: Thorax, "seventh cervical vertebra", Single ["c7", "cv7"];
    T2: Thorax, "second thoracic vertebra", Single ["t2"];
    T10: Thorax, "tenth thoracic vertebra", Single ["t10"];
    Clavicle: Thorax, "suprasternal notch", Single ["clav", "ij", "sternotch", "sternalnotch", "jn"];
    ClavicleEnd: Thorax, "collar bone", Paired ["cla", "clavicle"];
    Sternum: Thorax, "xiphoid process", Single ["strn", "px", "sternum", "xiphoid"];
    Shoulder: Alone, "shoulder", Paired ["sho", "shoulder", "acr", "acrom", "acromion", "acromium"];
    ShoulderFront: Alone, "front of the shoulder", Paired ["ash", "ashv"];
    ShoulderBack: Alone, "back of the shoulder", Paired ["psh", "pshv"];
    UpperArmCluster: UpperArm, "upper arm", Paired ["upa", "bicep", "biceps", "ua1", "ua2", "ua3"];
    Elbow: UpperArm, "lateral elbow", Paired ["elb", "elbow", "lel", "elbowlateral"];
    ElbowMedial: UpperArm, "medial elbow", Paired ["mel", "elbm", "elbowmedial"];
    ForearmCluster: Forearm, "forearm", Paired ["frm", "forearm", "fasuperior"];
    WristThumb: Forearm, "wrist, thumb side", Paired ["wra", "wrist", "wri", "wristlat", "faradius"];
    WristLittle: Forearm, "wrist, little finger side", Paired ["wrb", "wristmed", "faulna"];
    Finger: Alone, "hand", Paired ["fin"];
    HeadFront: Head, "front of the head", Paired ["fhd"];
    HeadBack: Head, "back of the head", Paired ["bhd"];
    Temple: Head, "temple", Paired ["temple"];
    HeadTop: Head, "top of the head", Single ["tophead"];
}

/// A place and its side, as named in errors and warnings.
pub(super) struct MarkerPlace(pub(super) Site, pub(super) MarkerSide);

impl fmt::Display for MarkerPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.1 {
            MarkerSide::Left => "left ",
            MarkerSide::Right => "right ",
            MarkerSide::Middle => "",
        })?;
        f.write_str(self.0.english())
    }
}

/// Returns the place and side that a marker name stands for, if the table knows it.
pub(super) fn place_of(name: &str) -> Option<(Site, MarkerSide)> {
    let bare = name.rsplit(':').next().unwrap_or(name);
    let key: String = bare
        .chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect();
    let look = |shape: SiteShape, key: &str| {
        TABLE
            .iter()
            .find(|(_, its, names)| *its == shape && names.contains(&key))
            .map(|(site, ..)| *site)
    };
    if let Some(site) = look(SiteShape::Single, &key) {
        return Some((site, MarkerSide::Middle));
    }
    let sides = [
        ("left", MarkerSide::Left),
        ("right", MarkerSide::Right),
        ("l", MarkerSide::Left),
        ("r", MarkerSide::Right),
    ];
    sides.into_iter().find_map(|(letter, side)| {
        let rest = key.strip_prefix(letter)?;
        Some((look(SiteShape::Paired, rest)?, side))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_stands_for_two_places() {
        let mut seen: Vec<String> = Vec::new();
        for (_, shape, names) in TABLE {
            for name in *names {
                let spelled = match shape {
                    SiteShape::Single => vec![(*name).to_owned()],
                    SiteShape::Paired => vec![format!("l{name}"), format!("r{name}")],
                };
                for name in spelled {
                    assert!(!seen.contains(&name), "{name}");
                    seen.push(name);
                }
            }
        }
    }

    #[test]
    fn prefix_case_and_punctuation_do_not_matter() {
        for name in [
            "LASI",
            "Anna:LASI",
            "a:b:lasi",
            "L.ASIS",
            "L_asis",
            "left asis",
        ] {
            assert_eq!(
                place_of(name),
                Some((Site::Asis, MarkerSide::Left)),
                "{name}"
            );
        }
        for (name, place) in [
            ("R.Knee.Medial", (Site::KneeMedial, MarkerSide::Right)),
            ("V.Sacral", (Site::Sacrum, MarkerSide::Middle)),
            ("RLMAL", (Site::Ankle, MarkerSide::Right)),
            ("LLMALv", (Site::Ankle, MarkerSide::Left)),
            ("L_ankle", (Site::Ankle, MarkerSide::Left)),
            ("l.heel", (Site::Heel, MarkerSide::Left)),
            ("LCAL", (Site::Heel, MarkerSide::Left)),
            ("lxlatmal", (Site::Ankle, MarkerSide::Left)),
            ("STER_NOTCH", (Site::Clavicle, MarkerSide::Middle)),
        ] {
            assert_eq!(place_of(name), Some(place), "{name}");
        }
    }

    #[test]
    fn angles_and_forces_are_no_markers() {
        for name in [
            "LKneeAngles",
            "RHipPower",
            "LAnkleMoment",
            "*52",
            "CentreOfMass",
            "qRPVX",
        ] {
            assert_eq!(place_of(name), None, "{name}");
        }
    }
}
