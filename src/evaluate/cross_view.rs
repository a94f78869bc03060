//! Rank-1 for every pair of probe view and gallery view, and its means as OpenGait computes them.
//!
//! Published numbers on CASIA-B and OU-MVLP are the mean over the gallery views, without the
//! identical one, then over the probe views.

use super::rank1::{ProbeOutcome, Tally};
use crate::error::{EvaluateError, Result};

/// A tally for each probe view and gallery view.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct CrossView {
    views: usize,
    /// Tallies `[probe view][gallery view]`.
    cells: Vec<Tally>,
}

/// Means of a [`CrossView`], percent.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CrossViewMeans {
    /// Mean over the gallery views, for each probe view.
    pub by_probe_view: Vec<f64>,
    /// Mean of [`Self::by_probe_view`].
    pub mean: f64,
}

impl CrossView {
    /// Creates an empty matrix of `views` probe views by `views` gallery views.
    #[must_use]
    pub(crate) fn new(views: usize) -> Self {
        Self {
            views,
            cells: vec![Tally::default(); views * views],
        }
    }

    /// Counts one more probe.
    ///
    /// # Panics
    /// If a view is not below the number of views.
    pub(crate) fn add(&mut self, probe_view: usize, gallery_view: usize, outcome: ProbeOutcome) {
        let at = self.at(probe_view, gallery_view);
        self.cells[at].add(outcome);
    }

    /// Returns the tally of a probe view against a gallery view.
    ///
    /// # Panics
    /// As [`Self::add`].
    #[must_use]
    pub(crate) fn cell(&self, probe_view: usize, gallery_view: usize) -> Tally {
        self.cells[self.at(probe_view, gallery_view)]
    }

    /// Returns the means as OpenGait computes them: without the identical view, each cell rounded
    /// to 0.01 % (halves to even, as `numpy.round`) before averaging.
    ///
    /// # Errors
    /// If there are fewer than two views, or a cell of different views has no probe.
    pub(crate) fn means(&self) -> Result<CrossViewMeans> {
        if self.views < 2 {
            return Err(EvaluateError::TooFewViews(self.views).into());
        }
        let mut by_probe_view = Vec::with_capacity(self.views);
        for probe_view in 0..self.views {
            let mut sum = 0.0;
            for gallery_view in (0..self.views).filter(|view| *view != probe_view) {
                let tally = self.cell(probe_view, gallery_view);
                if tally.probes == 0 {
                    return Err(EvaluateError::EmptyCell {
                        probe: probe_view,
                        gallery: gallery_view,
                    }
                    .into());
                }
                let percent = 100.0 * tally.hits as f64 / tally.probes as f64;
                sum += (percent * 100.0).round_ties_even() / 100.0;
            }
            by_probe_view.push(sum / (self.views - 1) as f64);
        }
        Ok(CrossViewMeans {
            mean: by_probe_view.iter().sum::<f64>() / self.views as f64,
            by_probe_view,
        })
    }

    fn at(&self, probe_view: usize, gallery_view: usize) -> usize {
        assert!(
            probe_view < self.views && gallery_view < self.views,
            "views {probe_view} and {gallery_view} of {}",
            self.views
        );
        probe_view * self.views + gallery_view
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a matrix of hits with `probes` probes in each cell.
    fn matrix_of(probes: u64, hits: &[&[u64]]) -> CrossView {
        let mut matrix = CrossView::new(hits.len());
        for (probe_view, row) in hits.iter().enumerate() {
            for (gallery_view, &hits) in row.iter().enumerate() {
                for probe in 0..probes {
                    let outcome = if probe < hits {
                        ProbeOutcome::Hit
                    } else {
                        ProbeOutcome::Miss
                    };
                    matrix.add(probe_view, gallery_view, outcome);
                }
            }
        }
        matrix
    }

    #[test]
    fn the_reference_matrix_has_its_worked_means() {
        let matrix = matrix_of(100, &[&[100, 80, 60], &[90, 100, 70], &[50, 75, 100]]);
        let means = matrix.means().unwrap();
        assert_eq!(means.by_probe_view, [70.0, 80.0, 62.5]);
        assert!((means.mean - 70.8333).abs() < 5e-5);
    }

    #[test]
    fn cells_are_rounded_before_they_are_averaged() {
        // 1/3 becomes 33.33 and 2/3 becomes 66.67. The errors cancel in the mean, not in the rows.
        let matrix = matrix_of(3, &[&[0, 1], &[2, 0]]);
        let rounded = matrix.means().unwrap();
        assert_eq!(rounded.by_probe_view, [33.33, 66.67]);
        // 1 in 800 is 0.125 %: numpy.round(0.125, 2) is 0.12.
        let matrix = matrix_of(800, &[&[0, 1], &[3, 0]]);
        let rounded = matrix.means().unwrap();
        assert_eq!(rounded.by_probe_view, [0.12, 0.38]);
    }

    #[test]
    fn an_empty_cell_and_a_lone_view_are_refused() {
        let mut matrix = CrossView::new(2);
        matrix.add(0, 1, ProbeOutcome::Hit);
        let error = matrix.means().unwrap_err();
        assert_eq!(
            error.to_string(),
            "cross-view matrix: no probe of view 1 was compared with gallery view 0, \
             expected one in every cell (leave the view out)"
        );
        matrix.add(1, 0, ProbeOutcome::NonFinite);
        let means = matrix.means().unwrap();
        assert_eq!(means.by_probe_view, [100.0, 0.0]);
        assert_eq!(matrix.cell(1, 0).non_finite, 1);
        assert!(CrossView::new(0).means().is_err());
        let lone = CrossView::new(1).means();
        assert!(lone.unwrap_err().to_string().contains("at least 2 views"));
    }
}
