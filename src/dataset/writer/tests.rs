//! Tests of writing datasets.

use super::*;
use crate::dataset::Dataset;
use crate::draw::template::Template;
use edgegait_core::budget::PIXELS;
use edgegait_core::silhouette::Size;

fn row() -> IndexRow {
    IndexRow {
        subject: "s".into(),
        walk: "w".into(),
        cycle: 0,
        variation: 0,
        speed_kmh: 4.0,
        azimuth_deg: 90.0,
        elevation_deg: 0.0,
        condition: "normal".into(),
        alternative: String::new(),
        frames: 8,
        seed: 1,
        ..IndexRow::default()
    }
}

fn run(size: Size, units: usize) -> DatasetRun {
    DatasetRun {
        header: ResultHeader::new("sweep", 1).with("size", size.name()),
        contents: Contents::one(Template::Gei, size),
        format: DatasetFormat::Folder,
        units,
        shard: None,
        is_recorded: false,
    }
}

fn push(writer: &mut DatasetWriter, bytes: &[u8], row: &IndexRow) -> Result<()> {
    writer.push(Item {
        row,
        take: "w",
        templates: &[bytes.to_vec()],
        joints: [&[], &[]],
    })
}

fn write(dir: &Path, shade: u8, existing: Existing) -> Result<()> {
    let mut writer = DatasetWriter::begin(dir, run(Size::S50x30, 1), existing, false)?;
    push(&mut writer, &[shade; PIXELS], &row())?;
    writer.end_unit()?;
    writer.finish()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect()
}

#[test]
fn a_dataset_that_is_not_finished_waits_or_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("d");
    let begin = |run, resume| DatasetWriter::begin(&dir, run, Existing::ReplaceOwn, resume);
    let mut writer = begin(run(Size::S50x30, 2), false).unwrap();
    push(&mut writer, &[1; PIXELS], &row()).unwrap();
    assert_eq!(names(folder.path()), ["d.unfinished"]);
    // No unit is finished, so nothing is kept.
    drop(writer);
    assert!(names(folder.path()).is_empty());

    let mut writer = begin(run(Size::S50x30, 2), false).unwrap();
    push(&mut writer, &[1; PIXELS], &row()).unwrap();
    writer.end_unit().unwrap();
    writer.note().unwrap();
    // The unfinished second unit is cut off.
    push(&mut writer, &[7; PIXELS], &row()).unwrap();
    let other = begin(run(Size::S50x30, 2), true).unwrap_err().to_string();
    assert!(other.ends_with("another process is using it"), "{other}");
    let short = writer.finish().unwrap_err().to_string();
    assert!(
        short.ends_with("expected 2 units of work, found 1"),
        "{short}"
    );
    assert_eq!(names(folder.path()), ["d.unfinished"]);
    let refused = begin(run(Size::S50x30, 2), false).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    assert!(refused.to_string().contains("did not finish"), "{refused}");
    let refused = begin(run(Size::S64x44, 2), true).unwrap_err().to_string();
    assert!(
        refused.contains(r#"settings.size is "50x30" there, "64x44" here"#),
        "{refused}"
    );

    let mut writer = begin(run(Size::S50x30, 2), true).unwrap();
    assert_eq!((writer.done(), writer.rows()), (1, 1));
    push(&mut writer, &[2; PIXELS], &row()).unwrap();
    writer.end_unit().unwrap();
    writer.finish().unwrap();
    assert_eq!(names(folder.path()), ["d"]);
    let dataset = Dataset::open(&dir).unwrap();
    assert!(dataset.templates().eq([[1; PIXELS], [2; PIXELS]]));
    let found = standing(&dir, &run(Size::S50x30, 2)).unwrap();
    assert_eq!(found, UnfinishedRun::Whole);
    let found = standing(&dir, &run(Size::S64x44, 2)).unwrap();
    assert!(matches!(found, UnfinishedRun::Other(_)), "{found:?}");
}

#[test]
fn a_folder_with_files_is_kept_unless_it_is_a_dataset_to_replace() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("d");
    fs::create_dir(&dir).unwrap();
    write(&dir, 1, Existing::ReplaceOwn).expect("an empty folder is no loss");
    write(&dir, 2, Existing::ReplaceOwn).expect("an earlier dataset of ours");
    let manifest = fs::read_to_string(dir.join(MANIFEST)).unwrap();
    let foreign = manifest.replace("\"sweep\"", "\"camera\"");
    fs::write(dir.join(MANIFEST), foreign).unwrap();
    let refused = write(&dir, 3, Existing::ReplaceOwn).unwrap_err();
    assert!(
        refused
            .to_string()
            .ends_with("a dataset that edgegait sweep did not make"),
        "{refused}"
    );
    assert_eq!(refused.exit_code(), 2);
    write(&dir, 2, Existing::Replace).unwrap();
    assert_eq!(Dataset::open(&dir).unwrap().bytes(0)[0], 2);

    fs::write(dir.join("thesis.tex"), "years").unwrap();
    let refused = write(&dir, 3, Existing::Replace).unwrap_err().to_string();
    assert!(
        refused.contains("holds thesis.tex, which is not part"),
        "{refused}"
    );
    assert_eq!(Dataset::open(&dir).unwrap().bytes(0)[0], 2);
    assert_eq!(names(folder.path()), ["d"]);

    fs::remove_file(dir.join("thesis.tex")).unwrap();
    fs::remove_file(dir.join(MANIFEST)).unwrap();
    let refused = write(&dir, 3, Existing::Replace).unwrap_err().to_string();
    assert!(
        refused.contains("no manifest.json, so it is not a dataset"),
        "{refused}"
    );
}

#[test]
fn a_file_where_the_folder_should_be_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("d");
    fs::write(&path, "mine").unwrap();
    assert!(write(&path, 1, Existing::Replace).is_err());
    assert_eq!(fs::read(&path).unwrap(), b"mine");
}

#[test]
fn a_row_that_cannot_be_and_geis_of_another_size_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("d");
    let mut writer =
        DatasetWriter::begin(dir, run(Size::S64x44, 1), Existing::ReplaceOwn, false).unwrap();
    let refused = push(&mut writer, &[0; PIXELS], &row())
        .unwrap_err()
        .to_string();
    assert!(
        refused.ends_with("row 0: expected the 2816 bytes of geis, found 1500"),
        "{refused}"
    );
    let bad = IndexRow { frames: 0, ..row() };
    let refused = push(&mut writer, &[0; 64 * 44], &bad)
        .unwrap_err()
        .to_string();
    assert!(
        refused.ends_with("row 0: expected frames >= 1, found 0"),
        "{refused}"
    );
}

#[test]
fn two_runs_write_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    write(&a, 5, Existing::ReplaceOwn).unwrap();
    write(&b, 5, Existing::ReplaceOwn).unwrap();
    for name in ["geis.npy", INDEX, MANIFEST] {
        assert_eq!(
            fs::read(a.join(name)).unwrap(),
            fs::read(b.join(name)).unwrap()
        );
    }
}

#[test]
fn an_empty_dataset_opens() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("new/d");
    let run = run(Size::S64x64, 0);
    let writer = DatasetWriter::begin(&dir, run, Existing::ReplaceOwn, false).unwrap();
    writer.finish().unwrap();
    let dataset = Dataset::open(&dir).unwrap();
    assert_eq!(
        (dataset.templates().len(), dataset.size()),
        (0, Size::S64x64)
    );
}
