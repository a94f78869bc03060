//! Jaccard indices against the true masks of rendered videos, with the given scene and with the
//! median.

/// The videos of people for choosing settings, and of others.
const CHOICES: [&str; 6] = [
    "people/video/105_nm-01_045",
    "people/video/106_nm-01_045",
    "people/video/107_nm-01_000",
    "people/video/110_nm-01_090",
    "people/video/120_nm-01_090",
    "people/video/121_nm-01_000",
];
const OTHERS: [&str; 4] = [
    "reallike/video/001_nm-01_045",
    "reallike/video/001_nm-01_090",
    "reallike/video/006_nm-01_045",
    "reallike/video/006_nm-01_090",
];

mod with_data {
    use super::*;
    use edgegait::Result;
    use edgegait::segment::{SegmentSettings, Segmenter, Video};
    use rayon::prelude::*;
    use std::fs;
    use std::path::{Path, PathBuf};

    /// Returns the folder of the videos.
    fn given() -> PathBuf {
        let folder = std::env::var_os("EDGEGAIT_DATA");
        folder
            .expect("EDGEGAIT_DATA: expected a folder with videos, found no such variable")
            .into()
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.expect("a file").path()).collect();
        files.sort();
        files
    }

    /// Returns the Jaccard index of each frame, in ascending order.
    fn jaccards(folder: &Path, background: Option<&Path>) -> Result<Vec<f64>> {
        let frames = folder.join("frames");
        let mut video = Video::open(&frames)?;
        let size = video.size();
        let (segmenter, _) =
            Segmenter::open(&frames, size, background, SegmentSettings::default())?;
        let mut masks = files(&folder.join("masks")).into_iter();
        let mut jaccards = Vec::new();
        loop {
            let batch = video.batch()?;
            if batch.is_empty() {
                assert!(masks.next().is_none(), "as many masks as frames");
                jaccards.sort_by(f64::total_cmp);
                return Ok(jaccards);
            }
            for frame in batch {
                let truth = image::open(masks.next().expect("a mask")).expect("a mask");
                let found = segmenter.segment(&frame).mask;
                let (mut both, mut either) = (0, 0);
                for (truth, on) in truth.into_luma8().pixels().zip(found.pixels()) {
                    let truth = truth.0[0] > 127;
                    both += u32::from(truth && *on);
                    either += u32::from(truth || *on);
                }
                jaccards.push(f64::from(both) / f64::from(either));
            }
        }
    }

    fn mean(of: &[f64]) -> f64 {
        of.iter().sum::<f64>() / of.len() as f64
    }

    fn shown(of: &Result<Vec<f64>>) -> String {
        match of {
            Ok(of) => format!("{:.3} {:.3} {:.3}", mean(of), of[of.len() / 20], of[0]),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn silhouettes_of_ten_videos_are_near_the_true_masks() {
        println!("video: mean, 5th percentile and least Jaccard, given; median; 10 empty frames");
        let videos: Vec<&str> = CHOICES.into_iter().chain(OTHERS).collect();
        let measured = |&video: &&'static str| {
            let folder = given().join(video);
            let of = |background| jaccards(&folder, background);
            let (picture, empty) = (folder.join("background.png"), folder.join("empty"));
            (video, [of(Some(&picture)), of(None), of(Some(&empty))])
        };
        let all: Vec<_> = videos.par_iter().map(measured).collect();
        for (video, [given, median, empty]) in all {
            println!(
                "{video}: {}; {}; {}",
                shown(&given),
                shown(&median),
                shown(&empty)
            );
            let given = given.expect("a scene");
            assert!(mean(&given) >= 0.9, "{video}");
            assert!(mean(&empty.expect("a scene")) >= 0.9, "{video}");
            // People who walk towards the camera are an error. Others are right, except for feet
            // that stand for half of a short video (0.894).
            let least = if video.contains("people") { 0.9 } else { 0.89 };
            match median {
                Ok(median) => assert!(mean(&median) >= least && !video.ends_with("000"), "{video}"),
                Err(error) => {
                    assert!(
                        !video.contains("people") || video.ends_with("000"),
                        "{error}"
                    );
                    assert!(error.to_string().contains("a figure that moves"), "{error}");
                }
            }
        }
    }

    #[test]
    #[ignore = "needs EDGEGAIT_DATA"]
    fn nobody_is_found_in_empty_frames() {
        for video in CHOICES.iter().chain(&OTHERS) {
            let folder = given().join(video);
            let empty = folder.join("empty");
            let mut frames = Video::open(&empty).expect("a folder");
            let size = frames.size();
            let picture = folder.join("background.png");
            let opened = Segmenter::open(&empty, size, Some(&picture), SegmentSettings::default());
            let (segmenter, _) = opened.expect("a scene");
            for frame in frames.batch().expect("frames") {
                assert_eq!(segmenter.segment(&frame).mask.area(), 0, "{video}");
            }
        }
    }
}
