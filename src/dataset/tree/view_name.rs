//! The names of views: `000`, `090`, `22.5`, `045e15`.

/// The viewpoint that a view's name states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NamedView {
    /// The azimuth, -360..=360 degrees.
    pub azimuth_deg: f64,
    /// The elevation, -90..=90 degrees.
    pub elevation_deg: f64,
}

impl NamedView {
    /// Returns the viewpoint that a name states, if any.
    pub(super) fn parse(name: &str) -> Option<Self> {
        let (azimuth, elevation) = name.split_once('e').unwrap_or((name, "0"));
        Some(Self {
            azimuth_deg: degrees(azimuth, 360.0)?,
            elevation_deg: degrees(elevation, 90.0)?,
        })
    }
}

/// Returns the error message for a name that states no viewpoint.
pub(super) fn expected(name: &str) -> String {
    format!(
        "expected the name of a view to be its azimuth in degrees (090), or azimuth and elevation (090e15), found {name:?}"
    )
}

/// Parses an angle of at most `most` degrees: digits, optionally with a minus and decimal point.
fn degrees(text: &str, most: f64) -> Option<f64> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let is_plain = digits.starts_with(|c: char| c.is_ascii_digit())
        && digits.chars().all(|c| c.is_ascii_digit() || c == '.');
    let number: f64 = text.parse().ok().filter(|_| is_plain)?;
    (number.abs() <= most).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_views_are_angles() {
        for (name, azimuth_deg, elevation_deg) in [
            ("000", 0.0, 0.0),
            ("090", 90.0, 0.0),
            ("270", 270.0, 0.0),
            ("18", 18.0, 0.0),
            ("22.5", 22.5, 0.0),
            ("-45", -45.0, 0.0),
            ("045e15", 45.0, 15.0),
            ("180e-7.5", 180.0, -7.5),
        ] {
            let expected = NamedView {
                azimuth_deg,
                elevation_deg,
            };
            assert_eq!(NamedView::parse(name), Some(expected), "{name}");
        }
    }

    #[test]
    fn other_names_are_no_angles() {
        for name in [
            "",
            "frames",
            "e15",
            "90e",
            "90e15e15",
            "361",
            "90e91",
            "1e",
            "nan",
            "inf",
            "+90",
            "0x5",
            "seq0",
            "camid0_videoid2",
        ] {
            assert_eq!(NamedView::parse(name), None, "{name}");
        }
    }
}
