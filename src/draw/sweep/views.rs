//! Lists of viewpoints: the paper's grid, the side view, or a user's own.

use crate::error::{Error, FilePlace, Result};
use edgegait_core::budget::MAX_ELEVATIONS;
use edgegait_core::camera::Viewpoint;
use edgegait_core::raster::columns::Azimuth;
use std::borrow::Cow;
use std::path::Path;

/// A viewpoint with the angles by which the user requested it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The azimuth, degrees; 0 is in front of the walker, 90 on the walker's left.
    pub azimuth_deg: f32,
    /// The elevation, degrees; 0 is level, 90 vertically above.
    pub elevation_deg: f32,
    viewpoint: Viewpoint,
}

impl View {
    /// Creates a view from degrees.
    ///
    /// # Errors
    /// For angles out of the range of viewpoints, and azimuths beyond a turn, which no dataset
    /// holds.
    pub fn new(azimuth_deg: f32, elevation_deg: f32) -> Result<Self> {
        if !(-360.0..=360.0).contains(&azimuth_deg) {
            return Err(Error::Usage(format!(
                "azimuth {azimuth_deg}: expected degrees within -360..=360"
            )));
        }
        let viewpoint = Viewpoint::from_degrees(azimuth_deg, elevation_deg)?;
        Ok(Self {
            azimuth_deg,
            elevation_deg,
            viewpoint,
        })
    }

    /// Creates a view from the angles of [`Self::angles_deg`].
    ///
    /// # Errors
    /// The errors of [`Self::new`].
    #[expect(clippy::cast_possible_truncation, reason = "degrees")]
    pub fn at((azimuth_deg, elevation_deg): (f64, f64)) -> Result<Self> {
        Self::new(azimuth_deg as f32, elevation_deg as f32)
    }

    /// Returns (azimuth, elevation), degrees.
    #[must_use]
    pub fn angles_deg(&self) -> (f64, f64) {
        (f64::from(self.azimuth_deg), f64::from(self.elevation_deg))
    }

    /// Returns the core's viewpoint.
    #[must_use]
    pub const fn viewpoint(&self) -> Viewpoint {
        self.viewpoint
    }
}

/// A list of at least one view.
#[derive(Clone, Debug, PartialEq)]
pub struct Views {
    /// The name that the user requested, for results.
    pub name: String,
    /// The views in order.
    pub list: Vec<View>,
}

impl Views {
    /// Returns the grid of Charalambous & Bharath (BMVC 2016): azimuth 0, 5, ..., 180 by elevation
    /// 0, 5, ..., 90 degrees, azimuth-major: 703 pairs, 667 directions.
    ///
    /// # Errors
    /// Never.
    pub fn paper() -> Result<Self> {
        let degrees = |last: u8| (0..=last).step_by(5).map(f32::from);
        Self::grid("paper", degrees(180), degrees(90))
    }

    /// Returns the side view: azimuth 90, elevation 0.
    ///
    /// # Errors
    /// Never.
    pub fn side() -> Result<Self> {
        Self::grid("side", [90.0], [0.0])
    }

    /// Combines every azimuth with every elevation, azimuth-major.
    ///
    /// # Errors
    /// For an angle out of the range of viewpoints, or an empty list.
    pub fn grid(
        name: impl Into<String>,
        azimuths: impl IntoIterator<Item = f32>,
        elevations: impl IntoIterator<Item = f32>,
    ) -> Result<Self> {
        let elevations: Vec<f32> = elevations.into_iter().collect();
        let mut list = Vec::new();
        for azimuth in azimuths {
            for &elevation in &elevations {
                list.push(View::new(azimuth, elevation)?);
            }
        }
        if list.is_empty() {
            return Err(Error::Usage("no viewpoints: expected at least one".into()));
        }
        Ok(Self {
            name: name.into(),
            list,
        })
    }

    /// Returns whether a view has this azimuth and elevation, degrees.
    #[must_use]
    pub fn has(&self, angles_deg: (f64, f64)) -> bool {
        self.list.iter().any(|view| view.angles_deg() == angles_deg)
    }

    /// Returns views by name (`paper`, `side`), or reads them from a CSV file with the columns
    /// `azimuth_deg` and `elevation_deg`.
    ///
    /// # Errors
    /// If the file cannot be read, or a row is not a viewpoint.
    pub fn named(name: &str) -> Result<Self> {
        match name {
            "paper" => Self::paper(),
            "side" => Self::side(),
            _ if Path::new(name).extension().is_some_and(|e| e == "csv") => {
                Self::from_csv(Path::new(name))
            }
            _ => Err(Error::Usage(format!(
                "viewpoints {name:?}: expected \"paper\", \"side\" or a .csv file"
            ))),
        }
    }

    fn from_csv(path: &Path) -> Result<Self> {
        #[derive(serde::Deserialize)]
        struct ViewRow {
            azimuth_deg: f32,
            elevation_deg: f32,
        }
        let file = crate::files::open(path)?;
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_reader(file);
        let mut list = Vec::new();
        for row in reader.deserialize() {
            let line = list.len() + 2;
            let row: ViewRow = row.map_err(|error| {
                Error::at(
                    path,
                    FilePlace::Line(line),
                    format!(
                        "{error}; expected the columns azimuth_deg and elevation_deg in degrees"
                    ),
                )
            })?;
            let view = View::new(row.azimuth_deg, row.elevation_deg)
                .map_err(|error| Error::at(path, FilePlace::Line(line), error.to_string()))?;
            list.push(view);
        }
        if list.is_empty() {
            return Err(Error::input(
                path,
                "no viewpoints: expected at least one row",
            ));
        }
        Ok(Self {
            name: path.display().to_string(),
            list,
        })
    }
}

/// Views of which each is drawn once, though the list may have it more than once: azimuths 0 and
/// 360, or -90 and 270, are equal.
pub(super) struct ListedViews<'v> {
    list: Cow<'v, [View]>,
    /// For each view the number of the first equal one: its own, or an earlier one.
    firsts: Cow<'v, [usize]>,
}

impl<'v> ListedViews<'v> {
    pub(super) fn new(list: impl Into<Cow<'v, [View]>>) -> Self {
        let list = list.into();
        let first = |(at, view): (usize, &View)| {
            let before = list.iter().take(at);
            let same = before
                .into_iter()
                .position(|other| other.viewpoint == view.viewpoint);
            same.unwrap_or(at)
        };
        let firsts = list.iter().enumerate().map(first).collect();
        Self { list, firsts }
    }

    /// Returns the same views, without copying them.
    pub(super) fn borrowed(&self) -> ListedViews<'_> {
        ListedViews {
            list: Cow::Borrowed(&self.list),
            firsts: Cow::Borrowed(&self.firsts),
        }
    }

    /// Returns all views.
    pub(super) fn list(&self) -> &[View] {
        &self.list
    }

    /// Returns for each view the number of the first equal one.
    pub(super) fn firsts(&self) -> &[usize] {
        &self.firsts
    }

    /// Returns the numbers of the views that are drawn: the first of each set of equal ones.
    pub(super) fn drawn(&self) -> Vec<usize> {
        let is_first = |&at: &usize| self.firsts[at] == at;
        (0..self.list.len()).filter(is_first).collect()
    }
}

/// Views of one azimuth that are drawn in one pass.
pub(super) struct Elevations {
    /// The directions of the azimuth, as the core draws them.
    pub azimuth: Azimuth,
    /// The numbers of the views.
    pub views: Vec<usize>,
}

/// Groups the numbered views by azimuth, with as many in each group as one pass can draw.
pub(super) fn by_azimuth(views: &[View], numbers: &[usize]) -> Result<Vec<Elevations>> {
    let right = |at: usize| views[at].viewpoint.right();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &at in numbers {
        let known = groups
            .iter_mut()
            .find(|known| known.len() < MAX_ELEVATIONS && right(known[0]) == right(at));
        match known {
            Some(known) => known.push(at),
            None => groups.push(vec![at]),
        }
    }
    let seen = |views_of: Vec<usize>| {
        let viewpoints: Vec<_> = views_of.iter().map(|&at| views[at].viewpoint).collect();
        let azimuth = Azimuth::new(&viewpoints)?;
        Ok(Elevations {
            azimuth,
            views: views_of,
        })
    };
    groups.into_iter().map(seen).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_grid_has_703_pairs_azimuth_major() {
        let views = Views::paper().expect("the grid").list;
        assert_eq!(views.len(), 703);
        let angles = |index: usize| (views[index].azimuth_deg, views[index].elevation_deg);
        assert_eq!(angles(0), (0.0, 0.0));
        assert_eq!(angles(1), (0.0, 5.0));
        assert_eq!(angles(19), (5.0, 0.0));
        assert_eq!(angles(702), (180.0, 90.0));
    }

    #[test]
    fn a_list_of_viewpoints_names_its_bad_line() {
        let dir = tempfile::tempdir().expect("a folder");
        let path = dir.path().join("views.csv");
        std::fs::write(&path, "azimuth_deg,elevation_deg\n90,0\n90,91\n").expect("a file");
        let error = Views::named(&path.display().to_string()).expect_err("91 degrees");
        assert!(error.to_string().contains("views.csv:3"), "{error}");
        std::fs::write(&path, "azimuth_deg,elevation_deg\n90,0\n45, 30\n").expect("a file");
        let views = Views::named(&path.display().to_string()).expect("two viewpoints");
        assert_eq!(views.list.len(), 2);
        assert!(Views::named("front").is_err());
    }

    #[test]
    fn viewpoints_that_are_the_same_are_known_by_the_first() {
        let azimuths = [0.0, 90.0, 360.0, -270.0, -90.0, 270.0, -360.0, 90.1];
        let views = Views::grid("list", azimuths, [0.0]).expect("viewpoints");
        assert_eq!(
            ListedViews::new(views.list).firsts(),
            [0, 1, 0, 1, 4, 4, 0, 7]
        );
        let paper = Views::paper().expect("the grid").list;
        assert_eq!(
            ListedViews::new(paper).firsts(),
            (0..703).collect::<Vec<_>>()
        );
    }

    #[test]
    fn views_are_gathered_by_azimuth_and_24_at_once() {
        let of = |azimuths: &[f32], elevations: &[f32]| {
            let azimuths = azimuths.iter().copied();
            let views = Views::grid("list", azimuths, elevations.iter().copied());
            let views = views.expect("viewpoints").list;
            let numbers: Vec<usize> = (0..views.len()).collect();
            let groups = by_azimuth(&views, &numbers).expect("groups");
            groups.into_iter().map(|it| it.views).collect::<Vec<_>>()
        };
        // Azimuths a whole turn apart are equal.
        assert_eq!(
            of(&[0.0, 5.0, 360.0], &[0.0, 9.0]),
            [vec![0, 1, 4, 5], vec![2, 3]]
        );
        let many: Vec<f32> = (0..30u8).map(f32::from).collect();
        let groups = of(&[0.0], &many);
        assert_eq!(groups, [(0..24).collect::<Vec<_>>(), (24..30).collect()]);
        assert_eq!(
            by_azimuth(
                &Views::paper().expect("grid").list,
                &(0..703).collect::<Vec<_>>()
            )
            .expect("groups")
            .len(),
            37
        );
    }
}
