//! Files of every format with deliberate faults: each is an error of one line that names the fault,
//! or is accepted with a warning about the repair. (For BVH see [`super::hard`].)

use super::hard::{Said, import, read_markers, warnings};
use crate::data::fixtures;
use edgegait::import::Markers;
use std::fs;
use std::path::Path;

use Ending::{Refused, Warned};

/// The outcome of importing a file.
enum Ending {
    /// An error that contains this text.
    Refused(&'static str),
    /// A pack, and a warning that contains this text.
    Warned(&'static str),
}

fn check(name: &str, said: &Said, ending: &Ending) {
    match (ending, &said.0) {
        (Refused(part), Err(error)) => assert!(error.contains(part), "{name}: {error}"),
        (Warned(part), Ok(output)) => {
            let is_warned = warnings(output).any(|warning| warning.contains(part));
            assert!(is_warned, "{name}: {output}");
        }
        _ => panic!("{name}: {:?}", said.0),
    }
}

/// Imports a file with this content and checks the outcome.
fn check_file(name: &str, file: &str, bytes: impl AsRef<[u8]>, ending: &Ending) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(file);
    fs::write(&path, bytes).expect("a file");
    check(name, &import(&path, None), ending);
}

fn fixture(name: &str) -> Vec<u8> {
    fs::read(fixtures().join("mocap/clips").join(name)).expect("a fixture")
}

/// Returns a fixture's text with `old`, which must occur, replaced by `new`.
fn replaced(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "{old}");
    text.replacen(old, new, 1)
}

#[test]
fn faults_of_an_amc_or_its_asf_are_reported() {
    let text = |name| {
        let text = String::from_utf8(fixture(name)).expect("ASCII");
        text.replace("\r\n", "\n")
    };
    let (amc, asf) = (text("cmu_amc/s02/02_01.amc"), text("cmu_amc/s02/02.asf"));
    let frame = |number: usize| amc.find(&format!("\n{number}\nroot ")).expect("a frame") + 1;
    let without = |from: usize, to: usize| amc[..from].to_owned() + &amc[to..];
    let ltibia = frame(60) + amc[frame(60)..].find("ltibia").expect("a bone");
    let end = ltibia + amc[ltibia..].find('\n').expect("a line") + 1;
    let amc_of = |text: String| (text, asf.clone());
    let asf_of = |old, new| (amc.clone(), replaced(&asf, old, new));
    for (name, (amc, asf), ending) in [
        (
            "whole",
            amc_of(amc.clone()),
            Warned("an AMC states no frame rate"),
        ),
        (
            "skips",
            amc_of(without(frame(50), frame(53))),
            Refused("expected frame 50, found 53"),
        ),
        (
            "twice",
            amc_of(replaced(&amc, "\n40\nroot", "\n39\nroot")),
            Refused("expected frame 40, found 39"),
        ),
        (
            "lacks",
            amc_of(without(ltibia, end)),
            Refused("frame 60 lacks the bone `ltibia`"),
        ),
        (
            "tail",
            amc_of(replaced(&amc, "lowerback", "tail")),
            Refused("no bone `tail` in the ASF"),
        ),
        (
            "unit",
            amc_of(replaced(&amc, ":DEGREES\n", "")),
            Warned("the AMC states no unit of angle"),
        ),
        (
            "nan",
            amc_of(replaced(&amc, "lowerback 7.86573", "lowerback nan")),
            Refused(":6: frame 1, `lowerback`: expected a finite number"),
        ),
        (
            "word",
            amc_of(replaced(&amc, "lowerback 7.86573", "lowerback x")),
            Refused("found `x`"),
        ),
        (
            "cut",
            amc_of(amc[..ltibia].to_owned()),
            Refused("frame 60 lacks the bone `ltibia`"),
        ),
        (
            "bare",
            amc_of(":FULLY-SPECIFIED\n:DEGREES\n".to_owned()),
            Refused("no frames"),
        ),
        (
            "empty",
            amc_of(String::new()),
            Refused("the motion has no frames"),
        ),
        (
            "lengthless",
            asf_of("  length 0.45\n", ""),
            Warned("the ASF states no unit of length"),
        ),
        (
            "cycle",
            asf_of("    rfoot rtoes\n", "    rfoot rtoes rfemur\n"),
            Refused("second parent"),
        ),
        (
            "zero",
            asf_of("direction 0.34202 -0.939693 0 ", "direction 0 0 0 "),
            Refused("direction is zero"),
        ),
        (
            "boneless",
            asf_of(":hierarchy", ":elsewhere"),
            Refused(".asf"),
        ),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let [amc_at, asf_at] = ["x.amc", "x.asf"].map(|file| folder.path().join(file));
        fs::write(&amc_at, amc).expect("a file");
        fs::write(&asf_at, asf).expect("a file");
        check(name, &import(&amc_at, Some(&asf_at)), &ending);
    }
}

const TRC: &str = "opensim/rajagopal/walk.trc";
/// The lines before the first frame.
const HEAD: usize = 6;

/// The cells of a TRC file, line by line.
struct Table(Vec<Vec<String>>);

impl Table {
    fn read() -> Self {
        let text = String::from_utf8(fixture(TRC)).expect("ASCII");
        let row = |line: &str| line.trim_end().split('\t').map(str::to_owned).collect();
        Self(text.lines().map(row).collect())
    }

    /// Returns the table with other coordinates of a marker in these frames.
    fn with(
        mut self,
        marker: &str,
        frames: std::ops::Range<usize>,
        cell: impl Fn(&str) -> String,
    ) -> Self {
        let column = self.column(marker);
        for row in &mut self.0[HEAD + frames.start..HEAD + frames.end] {
            for value in &mut row[column..column + 3] {
                *value = cell(value);
            }
        }
        self
    }

    fn column(&self, marker: &str) -> usize {
        self.0[3]
            .iter()
            .position(|name| name == marker)
            .expect("a marker")
    }

    fn text(&self) -> String {
        self.0.iter().map(|row| row.join("\t") + "\n").collect()
    }

    /// Returns the table's text with `old` replaced by `new`.
    fn replaced(&self, old: &str, new: &str) -> String {
        replaced(&self.text(), old, new)
    }
}

/// The frames in which the left ankle is hidden: a tenth of a second.
const GAP: std::ops::Range<usize> = 100..110;

fn markers_of(folder: &Path, text: &str) -> Markers {
    let path = folder.join("x.trc");
    fs::write(&path, text).expect("a file");
    read_markers(&path)
}

#[test]
fn blank_nan_zero_and_9999999_hide_a_marker() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = markers_of(folder.path(), &Table::read().text());
    let ankle = whole
        .names
        .iter()
        .position(|name| name == "L.Ankle")
        .expect("a marker");
    for hidden in ["", "NaN", "0.000", "9999999"] {
        let text = Table::read().with("L.Ankle", GAP, |_| hidden.into()).text();
        let markers = markers_of(folder.path(), &text);
        assert_eq!(markers.frames.len(), whole.frames.len());
        for (frame, (ours, all)) in markers.frames.iter().zip(&whole.frames).enumerate() {
            for (marker, (ours, all)) in ours.iter().zip(all).enumerate() {
                let is_hidden = marker == ankle && GAP.contains(&frame);
                assert_eq!(*ours, all.filter(|_| !is_hidden), "{hidden:?} {frame}");
            }
        }
    }
}

#[test]
fn faults_of_a_trc_are_reported() {
    let table = Table::read;
    let exchanged = || {
        let mut table = table();
        let [left, right] = ["L.Ankle", "R.Ankle"].map(|name| table.column(name));
        for row in &mut table.0[HEAD + 120..] {
            for axis in 0..3 {
                row.swap(left + axis, right + axis);
            }
        }
        table.text()
    };
    let far = |value: &str| format!("{}", value.parse::<f64>().expect("a number") + 4000.0);
    let cut = table().0[..HEAD + 1].len();
    let headless = Table(table().0[..2].to_vec()).text();
    let names = |old: &str| table().text().replace(old, "Q");
    for (name, text, ending) in [
        (
            "frames",
            table().replaced("100.0\t\t  100.0\t\t    238", "100.0\t\t  100.0\t\t    900"),
            Warned("`900` frames stated, 238 present"),
        ),
        (
            "markers",
            table().replaced("\t     41\t", "\t     43\t"),
            Warned("`43` markers stated, 41 present"),
        ),
        (
            "unit",
            table().replaced("\t mm\t", "\t m\t"),
            Warned("the stated unit makes the legs"),
        ),
        (
            "rate",
            table().replaced("  100.0\t\t  100.0\t", "  150.0\t\t  150.0\t"),
            Warned("the time column is used"),
        ),
        ("sides", exchanged(), Warned("change place")),
        (
            "spike",
            table().with("L.Ankle", 130..131, far).text(),
            Warned("jumps at frame 130"),
        ),
        (
            "one",
            Table(table().0[..cut].to_vec()).text(),
            Refused("is seen in 1 of 1 frames"),
        ),
        (
            "headless",
            headless,
            Refused("expected the header's values"),
        ),
        (
            "word",
            table().with("L.Ankle", 20..21, |_| "x".into()).text(),
            Refused("found `x`"),
        ),
        (
            "pelvis",
            names("ASIS"),
            Refused("anterior superior iliac spine"),
        ),
        (
            "strange",
            table().0.len().to_string(),
            Refused("PathFileType"),
        ),
        ("empty", String::new(), Refused("the file is empty")),
    ] {
        check_file(name, "x.trc", text, &ending);
    }
}

const C3D: &str = "auckland_c3dparser/Sydney_S4/AMGait03.c3d";

#[test]
fn faults_of_a_c3d_are_reported() {
    let whole = fixture(C3D);
    let edited = |at: usize, bytes: &[u8]| {
        let mut file = whole.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        file
    };
    let find = |part: &[u8]| {
        let mut windows = whole.windows(part.len());
        windows.position(|window| window == part).expect("a name")
    };
    let half = whole.len() / 2;
    let units = find(b"UNITS");
    for (name, bytes, ending) in [
        (
            "cut",
            whole[..half].to_vec(),
            Refused("the file ends after"),
        ),
        ("header", whole[..100].to_vec(), Refused("byte")),
        // The length of a parameter's data, and its name.
        (
            "overflow",
            edited(units + 8, &[255, 255]),
            Refused("at byte"),
        ),
        (
            "name",
            edited(units, &[0xC0, 0xC1]),
            Refused("a name that is not ASCII"),
        ),
        // The second byte of every C3D file is 0x50.
        ("magic", edited(1, &[0]), Refused("expected a C3D header")),
        ("text", b"HIERARCHY\n".to_vec(), Refused("byte")),
        ("empty", Vec::new(), Refused("the file is empty")),
    ] {
        check_file(name, "x.c3d", bytes, &ending);
    }
}

#[test]
fn faults_of_a_glb_are_reported() {
    let whole = fs::read(fixtures().join("truth/avatars/F_slim.glb")).expect("a fixture");
    let edited = |old: &str, new: &str| {
        assert_eq!(old.len(), new.len());
        let mut windows = whole.windows(old.len());
        let at = windows.position(|window| window == old.as_bytes());
        let at = at.expect("a part");
        let mut file = whole.clone();
        file[at..at + new.len()].copy_from_slice(new.as_bytes());
        file
    };
    for (name, bytes, ending) in [
        ("two clips", whole.clone(), Refused("--clip")),
        ("cut", whole[..whole.len() / 2].to_vec(), Refused("x.glb")),
        (
            "skinless",
            edited("\"skins\"", "\"skims\""),
            Refused("skin"),
        ),
        ("version", edited("\"2.0\"", "\"9.0\""), Refused("x.glb")),
        ("text", b"HIERARCHY\n".to_vec(), Refused("x.glb")),
        ("empty", Vec::new(), Refused("not a complete glTF 2.0 file")),
    ] {
        check_file(name, "x.glb", bytes, &ending);
    }
}
