//! A dataset on disk, checked when it is opened and then read without errors.

use std::path::{Path, PathBuf};

use super::index::{read_index, read_plain_index};
use super::manifest::read_manifest;
use super::npy::template_bytes;
use super::pictures::GeiPictures;
use super::pixel_check::check_gei;
use super::{INDEX, IndexRow, MANIFEST, Manifest, file_of};
use crate::draw::template::Template;
use crate::error::{Error, Remedy, Result};
use crate::files::{InputFile, sha256_of_bytes};
use edgegait_core::silhouette::Size;

/// A dataset in memory: a byte for each number, and the index.
#[derive(Clone, Debug)]
pub struct Dataset {
    manifest: Manifest,
    index: Vec<IndexRow>,
    npy: Vec<u8>,
    first: usize,
    size: Size,
}

impl Dataset {
    /// Reads a dataset folder and checks it. A folder without a manifest holds a user's own GEIs:
    /// `geis.npy`, and `index.csv` with a column `subject` and any of the other columns; or a tree
    /// with a `gei.png` for each view.
    ///
    /// # Errors
    ///
    /// If a file is missing or invalid, disagrees in its count with the other two, or
    /// does not have the SHA-256 in the manifest. The
    /// error names the file and, for text, the line.
    pub fn open(dir: impl AsRef<Path>) -> Result<Self> {
        let dir = dir.as_ref();
        let has_manifest = dir.join(MANIFEST).exists();
        let manifest = if has_manifest {
            Some(read_manifest(&dir.join(MANIFEST))?)
        } else {
            None
        };
        let manifest = manifest.unwrap_or_else(Manifest::plain);
        if let Some(pictures) = Self::pictures(dir) {
            let (index, size, npy) = pictures.read()?;
            let dataset = Self {
                manifest,
                index,
                npy,
                first: 0,
                size,
            };
            dataset.check_pixels(dir)?;
            return Ok(dataset);
        }
        let (template, name) = (manifest.template, file_of(manifest.template));
        if template == Template::Silhouettes {
            return Err(Error::input(
                dir.join(MANIFEST),
                "expected one template of each row, found silhouettes",
            )
            .with_remedy(Remedy::OtherTemplate));
        }
        let (npy_path, npy) = read(dir, &name, &manifest)?;
        let (first, size, count) = template_bytes(&npy_path, &npy, template, manifest.size())?;
        if has_manifest && count != manifest.geis {
            return Err(Error::input(
                npy_path,
                format!(
                    "expected {} {}, as {MANIFEST} says, found {count}",
                    manifest.geis,
                    template.plural()
                ),
            ));
        }
        let (index_path, text) = read(dir, INDEX, &manifest)?;
        let index = if has_manifest {
            read_index(&index_path, &text)?
        } else {
            read_plain_index(&index_path, &text)?
        };
        if index.len() != count {
            return Err(Error::input(
                index_path,
                format!(
                    "expected {count} rows, one for each {} of {name}, found {}",
                    match template {
                        Template::Gei => "GEI",
                        other => other.name(),
                    },
                    index.len()
                ),
            ));
        }
        let dataset = Self {
            manifest,
            index,
            npy,
            first,
            size,
        };
        if template == Template::Gei && dataset.manifest.files.is_empty() {
            dataset.check_pixels(&npy_path)?;
        }
        Ok(dataset)
    }

    /// Returns what is to be said of a folder if it is a tree with a GEI as a picture for each view.
    #[must_use]
    pub fn said_of_pictures(folder: &Path) -> Option<String> {
        let said = || {
            let folder = folder.display();
            format!("{folder}: the gei.png of each view is read as a template, not as silhouettes")
        };
        Self::pictures(folder).map(|_| said())
    }

    pub(super) fn pictures(folder: &Path) -> Option<GeiPictures> {
        let is_stored = [MANIFEST, INDEX]
            .iter()
            .any(|name| folder.join(name).exists());
        if is_stored {
            None
        } else {
            GeiPictures::find(folder)
        }
    }

    /// Checks that GEIs which no manifest vouches for are white on black, from 0 to 255.
    fn check_pixels(&self, path: &Path) -> Result<()> {
        for (row, gei) in self.templates().enumerate() {
            check_gei(gei, self.size.columns())
                .map_err(|problem| Error::input(path, format!("GEI {row}: {problem}")))?;
        }
        Ok(())
    }

    /// Returns the files that identify a dataset folder: the manifest, which holds the hashes of
    /// the others, or the others if there is no manifest.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn inputs(folder: &Path) -> Result<Vec<InputFile>> {
        let manifest = folder.join(MANIFEST);
        if manifest.exists() {
            return Ok(vec![InputFile::read(manifest)?]);
        }
        if let Some(pictures) = Self::pictures(folder) {
            return pictures.paths().map(InputFile::read).collect();
        }
        let files = [file_of(Template::Gei), INDEX.to_owned()];
        files
            .iter()
            .map(|name| InputFile::read(folder.join(name)))
            .collect()
    }

    /// Returns the manifest of the dataset.
    #[must_use]
    pub const fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Returns the rows of the index, in the order of [`Self::templates`].
    #[must_use]
    pub fn index(&self) -> &[IndexRow] {
        &self.index
    }

    /// Returns the kind of template that the dataset holds.
    #[must_use]
    pub const fn template(&self) -> Template {
        self.manifest.template
    }

    /// Returns the size of the silhouettes that the templates are made of.
    #[must_use]
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Returns the bytes of each template in the order of [`Self::index`]; images are stored row by
    /// row from the top.
    ///
    /// # Guarantees
    ///
    /// The iterator has as many items as the index has rows, each of the length that
    /// [`Template::shape`] states.
    pub fn templates(&self) -> std::slice::ChunksExact<'_, u8> {
        self.npy[self.first..].chunks_exact(self.template().shape(self.size).numbers())
    }

    /// Returns the bytes of one template.
    ///
    /// # Panics
    ///
    /// If the index has no such row.
    #[must_use]
    pub fn bytes(&self, row: usize) -> &[u8] {
        let numbers = self.template().shape(self.size).numbers();
        &self.npy[self.first + row * numbers..][..numbers]
    }
}

fn read(dir: &Path, name: &str, manifest: &Manifest) -> Result<(PathBuf, Vec<u8>)> {
    let path = dir.join(name);
    let bytes = crate::files::read(&path)?;
    if let Some(file) = manifest.files.iter().find(|file| file.path == name) {
        let found = sha256_of_bytes(&bytes);
        if found != file.sha256 {
            return Err(Error::input(
                path,
                format!(
                    "expected SHA-256 {}, as {MANIFEST} says, found {found} (the file was changed: \
                     make the dataset again, or empty \"files\" in {MANIFEST} to accept it)",
                    file.sha256
                ),
            ));
        }
    }
    Ok((path, bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{Contents, DatasetFormat, DatasetRun, DatasetWriter, Existing, Item};
    use crate::files::ResultHeader;
    use edgegait_core::budget::PIXELS;
    use std::fs;

    fn row(subject: &str, azimuth_deg: f64) -> IndexRow {
        IndexRow {
            subject: subject.into(),
            walk: "w1".into(),
            cycle: 0,
            variation: 0,
            speed_kmh: 4.5,
            azimuth_deg,
            elevation_deg: 0.0,
            condition: "normal".into(),
            alternative: String::new(),
            frames: 32,
            seed: 9,
            ..IndexRow::default()
        }
    }

    fn write(dir: &Path, contents: Contents, header: ResultHeader, rows: &[(Vec<u8>, IndexRow)]) {
        let run = DatasetRun {
            header,
            contents,
            format: DatasetFormat::Folder,
            units: 0,
            shard: None,
            is_recorded: false,
        };
        let mut writer = DatasetWriter::begin(dir, run, Existing::ReplaceOwn, false).unwrap();
        for (bytes, row) in rows {
            let item = Item {
                row,
                take: "w1",
                templates: std::slice::from_ref(bytes),
                joints: [&[], &[]],
            };
            writer.push(item).unwrap();
        }
        writer.finish().unwrap();
    }

    fn written() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path().join("walks");
        let rows = [
            (vec![3; PIXELS], row("a", 0.0)),
            (vec![250; PIXELS], row("b", 90.0)),
        ];
        let contents = Contents::one(Template::Gei, Size::S50x30);
        let header = ResultHeader::new("sweep", 1).with("framing", "height");
        write(&dir, contents, header, &rows);
        (folder, dir)
    }

    /// Removes the hashes from the manifest, so that later checks run.
    fn without_hashes(dir: &Path) {
        let path = dir.join(MANIFEST);
        let mut manifest = read_manifest(&path).unwrap();
        manifest.files.clear();
        fs::write(&path, serde_json::to_vec(&manifest).unwrap()).unwrap();
    }

    fn refusal(dir: &Path) -> String {
        let text = Dataset::open(dir).unwrap_err().to_string();
        text.replace(&format!("{}/", dir.display()), "")
    }

    #[test]
    fn a_dataset_comes_back_as_it_was_written() {
        let (_folder, dir) = written();
        let dataset = Dataset::open(&dir).unwrap();
        assert!(dataset.templates().eq([[3; PIXELS], [250; PIXELS]]));
        assert_eq!(dataset.bytes(1), [250; PIXELS]);
        assert_eq!(dataset.index(), [row("a", 0.0), row("b", 90.0)]);
        assert_eq!(dataset.manifest().header.settings["framing"], "height");
        assert_eq!(dataset.manifest().geis, 2);
    }

    /// Writes two templates, all 3 and all 250, of silhouettes of 64 by 44 pixels.
    fn written_as(template: Template) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path().join("walks");
        let size = Size::S64x44;
        let rows = [(3, "a"), (250, "b")].map(|(shade, subject)| {
            let bytes = vec![shade; template.shape(size).numbers()];
            (bytes, row(subject, 0.0))
        });
        let header = ResultHeader::new("sweep", 1).with("size", size.name());
        write(&dir, Contents::one(template, size), header, &rows);
        (folder, dir)
    }

    #[test]
    fn another_template_is_in_a_file_of_its_name() {
        for (template, name, numbers) in [
            (Template::Mhi, "mhi.npy", 64 * 44),
            (Template::Frequency, "frequency.npy", 3 * 64 * 44),
            (Template::RowWidth, "row-width.npy", 64),
            (Template::Kfd, "kfd.npy", 60),
        ] {
            let (_folder, dir) = written_as(template);
            assert_eq!(fs::read(dir.join(name)).unwrap().len(), 128 + 2 * numbers);
            let dataset = Dataset::open(&dir).unwrap();
            assert_eq!(
                (dataset.template(), dataset.size()),
                (template, Size::S64x44)
            );
            assert!(
                dataset
                    .templates()
                    .eq([vec![3; numbers], vec![250; numbers]])
            );
            assert_eq!(dataset.bytes(1), vec![250; numbers]);
        }
        // The file that the manifest names is opened.
        let (_folder, dir) = written_as(Template::Mhi);
        let manifest = fs::read_to_string(dir.join(MANIFEST)).unwrap();
        let manifest = manifest.replace("\"template\": \"mhi\"", "\"template\": \"kfd\"");
        fs::write(dir.join(MANIFEST), manifest).unwrap();
        assert!(refusal(&dir).starts_with("kfd.npy: No such file"));
    }

    #[test]
    fn a_file_that_was_changed_is_refused() {
        let (_folder, dir) = written();
        let mut bytes = fs::read(dir.join("geis.npy")).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        fs::write(dir.join("geis.npy"), bytes).unwrap();
        let refusal = refusal(&dir);
        assert!(
            refusal.starts_with("geis.npy: expected SHA-256 "),
            "{refusal}"
        );
        without_hashes(&dir);
        assert_eq!(Dataset::open(&dir).unwrap().bytes(1)[PIXELS - 1], 251);
    }

    #[test]
    fn counts_that_disagree_are_refused() {
        let (_folder, dir) = written();
        without_hashes(&dir);
        let index = fs::read_to_string(dir.join(INDEX)).unwrap();
        let shorter: Vec<_> = index.lines().take(2).collect();
        fs::write(dir.join(INDEX), shorter.join("\n")).unwrap();
        assert_eq!(
            refusal(&dir),
            "index.csv: expected 2 rows, one for each GEI of geis.npy, found 1"
        );
        fs::write(dir.join(INDEX), index).unwrap();
        let manifest = fs::read_to_string(dir.join(MANIFEST)).unwrap();
        fs::write(
            dir.join(MANIFEST),
            manifest.replace("\"geis\":2", "\"geis\":3"),
        )
        .unwrap();
        assert_eq!(
            refusal(&dir),
            "geis.npy: expected 3 GEIs, as manifest.json says, found 2"
        );
    }

    #[test]
    fn geis_of_ones_own_need_a_person_each_and_no_more() {
        let (_folder, dir) = written();
        fs::remove_file(dir.join(MANIFEST)).unwrap();
        let index = |text: &str| fs::write(dir.join(INDEX), text).unwrap();
        index("subject,walk,azimuth_deg\nann,nm-01,90\nbob,\"bg, 1\",-18\n");
        let dataset = Dataset::open(&dir).unwrap();
        assert_eq!(
            (dataset.template(), dataset.size()),
            (Template::Gei, Size::S50x30)
        );
        let rows: Vec<_> = dataset
            .index()
            .iter()
            .map(|row| (&*row.subject, &*row.walk, row.azimuth_deg))
            .collect();
        assert_eq!(rows, [("ann", "nm-01", 90.0), ("bob", "bg, 1", -18.0)]);
        assert_eq!(dataset.bytes(1), [250; PIXELS]);
        for (text, problem) in [
            (
                "walk,azimuth_deg\na,9\nb,9\n",
                "index.csv:1: expected a column subject, found none",
            ),
            (
                "subject,view\na,9\nb,9\n",
                "each at most once, found \"view\"",
            ),
            (
                "subject,walk,subject\na,9,a\nb,9,b\n",
                "each at most once, found \"subject\"",
            ),
            (
                "subject\na\n",
                "index.csv: expected 2 rows, one for each GEI of geis.npy, found 1",
            ),
            (
                "subject,azimuth_deg\na,90\nb,left\n",
                "index.csv:3: azimuth_deg: invalid float",
            ),
            (
                "subject,azimuth_deg\na,90\nb,900\n",
                "index.csv:3: expected azimuth_deg from -360",
            ),
            (
                "subject,walk\na,90\nb\n",
                "index.csv:3: expected 2 fields, found 1",
            ),
            (
                "subject\na\n\"\"\n",
                "index.csv:3: expected a subject, found an empty field",
            ),
        ] {
            index(text);
            assert!(refusal(&dir).contains(problem), "{}", refusal(&dir));
        }
    }

    #[test]
    fn a_manifest_of_another_version_or_none_is_refused() {
        let (_folder, dir) = written();
        let manifest = fs::read_to_string(dir.join(MANIFEST)).unwrap();
        fs::write(
            dir.join(MANIFEST),
            manifest.replace("\"schema\": 1", "\"schema\": 2"),
        )
        .unwrap();
        assert_eq!(
            refusal(&dir),
            "manifest.json: expected schema 1, found 2 (was it made by another version?)"
        );
        fs::write(dir.join(MANIFEST), "{\n\"schema\": 1,\n").unwrap();
        assert!(
            refusal(&dir).starts_with("manifest.json:3: EOF"),
            "{}",
            refusal(&dir)
        );
    }
}
