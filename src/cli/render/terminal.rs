//! Walks on a terminal: a moving figure, and two moments as text.

use super::groups::{ShownCycle, ShownGroup};
use crate::cli::stop::Stop;
use crate::error::Result;
use edgegait_core::silhouette::{AnySilhouette, Silhouette};
use std::fmt::Write as _;
use std::time::Duration;

/// Shows a walk on a terminal for as long as two gait cycles last, or until it is interrupted, and
/// clears it again.
pub(super) fn walk_on(
    out: &mut impl std::io::Write,
    frames: &[AnySilhouette],
    each_s: f64,
    stop: &Stop,
) -> Result<()> {
    let each = Duration::from_secs_f64(each_s.clamp(0.01, 1.0));
    for frame in frames.iter().chain(frames) {
        stop.check()?;
        let silhouette = frame.silhouette();
        let rows = (0..silhouette.size().rows()).step_by(2);
        // Erases the rest of each line, and goes back to the first.
        let mut text: String = rows
            .clone()
            .map(|row| half_blocks(&silhouette, row) + "\x1b[K\n")
            .collect();
        let _ = write!(text, "\x1b[{}A", rows.len());
        // A terminal that is gone shows nothing.
        if out
            .write_all(text.as_bytes())
            .and_then(|()| out.flush())
            .is_err()
        {
            break;
        }
        std::thread::sleep(each);
    }
    let _ = out.write_all(b"\x1b[J");
    Ok(())
}

/// Draws two frames of a cycle side by side as text, with two rows of pixels in a line: at phases 0
/// and 0.25, or the first and last frame.
pub(super) fn text_art(group: &ShownGroup, member: &ShownCycle) -> String {
    let (later, when) = &group.later;
    let last = member.frames.len().saturating_sub(1);
    let shown = [0, (*later).min(last)].map(|index| member.frames[index].silhouette());
    let mut text = format!("{}, {when}\n", group.name);
    for row in (0..shown[0].size().rows()).step_by(2) {
        let line = shown.map(|silhouette| half_blocks(&silhouette, row));
        let _ = writeln!(text, "{}", line.join("    ").trim_end());
    }
    text
}

/// Draws two rows of pixels as one line of half blocks.
fn half_blocks(silhouette: &Silhouette, row: usize) -> String {
    (0..silhouette.size().columns())
        .map(|column| {
            match (
                silhouette.is_on(row, column),
                silhouette.is_on(row + 1, column),
            ) {
                (true, true) => '█',
                (true, false) => '▀',
                (false, true) => '▄',
                (false, false) => ' ',
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use edgegait_core::silhouette::Size;

    #[test]
    fn a_walker_on_a_terminal_leaves_nothing_behind() {
        let size = Size::S50x30;
        let frames: Vec<AnySilhouette> = (0..3)
            .map(|at| {
                let rows: Vec<u64> = (0..50).map(|row| u64::from(row == at)).collect();
                AnySilhouette::Binary(Silhouette::from_rows(size, &rows))
            })
            .collect();
        let mut out = Vec::new();
        walk_on(&mut out, &frames, 0.0, &Stop::default()).expect("shown");
        let text = String::from_utf8(out).expect("text");
        // Two cycles of three frames, each of 25 lines; each goes back over them.
        assert_eq!(text.matches("\x1b[25A").count(), 6);
        assert_eq!(text.matches("\x1b[K\n").count(), 150);
        assert!(text.ends_with("\x1b[25A\x1b[J"), "{text:?}");
        let shown: String = text.chars().filter(|sign| "▀▄".contains(*sign)).collect();
        assert_eq!(shown, "▀▄▀▀▄▀");
        let stop = Stop::default();
        stop.end();
        let mut none = Vec::new();
        assert!(walk_on(&mut none, &frames, 0.0, &stop).is_err());
        assert!(none.is_empty());
    }
}
