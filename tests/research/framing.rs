//! Makes the differences of framing in src/guide/datasets.md: frames as EdgeGait and as OpenGait's
//! pretreatment centre them.

use crate::data::given;
use edgegait::dataset::TreeLayout;
use edgegait::{FramingMode, Tree};
use edgegait_core::silhouette::Size;
use image::GrayImage;
use std::fs;
use std::path::PathBuf;

/// Normalises a frame like OpenGait's `datasets/pretreatment.py`, written from its description: cut
/// to the figure's rows, scaled to 64 rows by OpenCV's cubic interpolation (a = -0.75, no
/// smoothing), and cut to 64 columns around the one in which half of the sum is reached.
fn pretreated(picture: &GrayImage) -> Option<Vec<u8>> {
    let width = picture.width() as usize;
    let rows: Vec<&[u8]> = picture.as_raw().chunks_exact(width).collect();
    let is_on = |row: &&[u8]| row.iter().any(|&pixel| pixel > 0);
    let top = rows.iter().position(is_on)?;
    let bottom = rows.iter().rposition(is_on)?;
    let cut = &rows[top..=bottom];
    let columns = 64 * width / cut.len();
    let weights = |to: usize, size: usize, scaled: usize| {
        let at = (to as f64 + 0.5) * size as f64 / scaled as f64 - 0.5;
        let t = at - at.floor();
        let near = |x: f64| (1.25 * x - 2.25) * x * x + 1.0;
        let far = |x: f64| -0.75 * (((x - 5.0) * x + 8.0) * x - 4.0);
        let taps = [far(1.0 + t), near(t), near(1.0 - t), far(2.0 - t)];
        let from = |tap: usize| {
            let place = at.floor() as i64 + tap as i64 - 1;
            place.clamp(0, size as i64 - 1) as usize
        };
        [0, 1, 2, 3].map(|tap| (from(tap), taps[tap]))
    };
    let scaled: Vec<Vec<f64>> = (0..64)
        .map(|row| {
            let of_row = weights(row, cut.len(), 64);
            let pixel = |column: usize| {
                let of_column = weights(column, width, columns);
                let sum = |&(row, weight): &(usize, f64)| {
                    let row = of_column.iter().map(|&(at, w)| w * f64::from(cut[row][at]));
                    weight * row.sum::<f64>()
                };
                of_row
                    .iter()
                    .map(sum)
                    .sum::<f64>()
                    .round()
                    .clamp(0.0, 255.0)
            };
            (0..columns).map(pixel).collect()
        })
        .collect();
    let all: f64 = scaled.iter().flatten().sum();
    let mut reached = 0.0;
    let centre = (0..columns).find(|&column| {
        reached += scaled.iter().map(|row| row[column]).sum::<f64>();
        reached > all / 2.0
    })?;
    let pixel = |row: usize, column: usize| {
        let at = (centre + column).checked_sub(32);
        at.and_then(|at| scaled[row].get(at))
            .copied()
            .unwrap_or(0.0) as u8
    };
    Some((0..64 * 64).map(|at| pixel(at / 64, at % 64)).collect())
}

mod with_data {
    use super::*;

    /// Measures the difference from OpenGait's framing that the guide reports.
    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn framing_here_and_in_opengaits_pretreatment_differ_by_a_column() {
        let tree =
            Tree::open(given().join("people/people"), &TreeLayout::default()).expect("a tree");
        println!("view: Jaccard of frames, of the best shift, mean shift, GEI RMSE of 255");
        for view in ["000", "045", "090"] {
            let (mut jaccard, mut best, mut shift, mut rmse) = (0.0, 0.0, 0.0, 0.0);
            let (mut frames, mut sequences) = (0.0, 0.0);
            let of_view =
                (0..tree.sequences().len()).filter(|&at| tree.sequences()[at].view == view);
            // Debug builds are slow, so they check every fourth.
            for at in of_view.step_by(if cfg!(debug_assertions) { 4 } else { 1 }) {
                let ours = tree
                    .silhouettes(at, Size::S64x64, FramingMode::Height)
                    .expect("readable");
                let entries = fs::read_dir(tree.folder(at)).expect("a folder");
                let mut files: Vec<PathBuf> =
                    entries.map(|entry| entry.expect("a file").path()).collect();
                files.sort();
                let theirs = files.iter().flat_map(|file| {
                    let picture = image::open(file).expect("a picture").into_luma8();
                    pretreated(&picture).expect("a figure")
                });
                let theirs: Vec<u8> = theirs.collect();
                assert_eq!(ours.pixels.len(), theirs.len());
                let count = ours.frames as f64;
                let (mut square, mut own) = (0.0, vec![[0.0; 2]; 64 * 64]);
                for (a, b) in ours
                    .pixels
                    .chunks_exact(4096)
                    .zip(theirs.chunks_exact(4096))
                {
                    let moved = |by: i64| {
                        let (mut both, mut any) = (0.0, 0.0);
                        for (place, &pixel) in a.iter().enumerate() {
                            let column = (place % 64) as i64 + by;
                            let other = (0..64)
                                .contains(&column)
                                .then(|| b[place - place % 64 + column as usize]);
                            let (one, two) = (pixel >= 128, other.is_some_and(|it| it >= 128));
                            both += f64::from(one && two);
                            any += f64::from(one || two);
                        }
                        both / any
                    };
                    let shifts = (-3..=3).map(|by| (by, moved(by)));
                    let (by, most) = shifts.max_by(|a, b| a.1.total_cmp(&b.1)).expect("some");
                    (jaccard, best) = (jaccard + moved(0), best + most);
                    shift += by.abs() as f64;
                    for (sum, (a, b)) in own.iter_mut().zip(a.iter().zip(b)) {
                        *sum = [
                            sum[0] + f64::from(*a) / count,
                            sum[1] + f64::from(*b) / count,
                        ];
                    }
                }
                own.iter()
                    .for_each(|[a, b]| square += (a - b).powi(2) / 4096.0);
                rmse += square.sqrt();
                frames += count;
                sequences += 1.0;
            }
            let [jaccard, best, shift] = [jaccard, best, shift].map(|sum| sum / frames);
            println!(
                "{view}: {jaccard:.3}, {best:.3}, {shift:.2} columns, {:.1}",
                rmse / sequences
            );
            assert!(best > 0.92 && shift < 1.0, "{view}");
        }
    }
}
