//! Formats a comparison as text.

use crate::evaluate::parity::{
    AnswerDifference, Comparison, Limits, ParityPart, ParityResults, ParitySide, Verdict,
};
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use std::fmt;

/// The greatest difference to expect from half precision, whose numbers have 11 bits. Our choice.
const HALF_PRECISION: f64 = 0.02;

/// The results as text.
pub(super) struct Text<'a>(pub(super) &'a ParityResults);

impl fmt::Display for Text<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let results = self.0;
        let reference = &results.sides[0];
        writeln!(f, "reference: {}", reference.label())?;
        for note in &reference.notes {
            writeln!(f, "  {note}")?;
        }
        writeln!(
            f,
            "{} inputs: {} people, {} viewpoints, protocol {}",
            results.sequences, results.people, results.viewpoints, results.protocol
        )?;
        for comparison in &results.comparisons {
            beside(f, reference, &results.sides[comparison.side], comparison)?;
        }
        Ok(())
    }
}

/// Writes the comparison of a side with the reference.
fn beside(
    f: &mut fmt::Formatter<'_>,
    reference: &ParitySide,
    side: &ParitySide,
    found: &Comparison,
) -> fmt::Result {
    let verdict = match found.verdict {
        Verdict::Same => "the same",
        Verdict::Differs => "DIFFERS",
    };
    writeln!(f, "\n{}: {verdict}", side.label())?;
    for note in &side.notes {
        writeln!(f, "  {note}")?;
    }
    let mut table = Table::new(&[Left(0), Right(8)]).with_gap(2);
    table.row([
        "  difference",
        "relative, greatest",
        "mean",
        "absolute, greatest",
        "mean",
        "worst cosine",
    ]);
    let row = |name: &str, one: &AnswerDifference| {
        let numbers = [
            one.greatest_relative,
            one.mean_relative,
            one.greatest,
            one.mean,
        ];
        let cells = numbers.map(short).into_iter();
        std::iter::once(format!("  {name}"))
            .chain(cells)
            .chain([format!("{:.6}", one.worst_cosine)])
            .collect::<Vec<_>>()
    };
    for (name, difference) in [("embedding", &found.embedding), ("scores", &found.scores)] {
        if let Some(one) = difference {
            table.row(row(name, one));
        }
    }
    let Limits {
        relative_difference,
        mean_relative_difference,
        changed_hits,
    } = found.limits;
    table.row([
        "  limit".to_owned(),
        short(relative_difference),
        short(mean_relative_difference),
    ]);
    writeln!(f, "{}", table.to_string().trim_end())?;
    if let Some(ranks) = &found.ranks {
        writeln!(
            f,
            "  rank-1: {:.2} % (reference: {:.2} %); of {} probes, {} lose and {} gain the right answer (limit {} %), {} have a different answer, and {} a different rank of the right person",
            100.0 * ranks.rank1,
            100.0 * ranks.rank1_of_reference,
            ranks.probes,
            ranks.lost,
            ranks.gained,
            100.0 * changed_hits,
            ranks.other_answers,
            ranks.other_ranks
        )?;
    }
    if found.verdict == Verdict::Same {
        return Ok(());
    }
    let places = found.worst.iter().map(|place| {
        let relative = place.relative.map_or("not finite".into(), short);
        format!(
            "{} {} at {} ({relative})",
            place.subject, place.take, place.view
        )
    });
    writeln!(f, "  farthest: {}", places.collect::<Vec<_>>().join(", "))?;
    for (what, parts) in [("viewpoint", &found.by_view), ("person", &found.by_subject)] {
        if let Some(part) = farthest(parts) {
            let not_finite = match part.non_finite {
                0 => String::new(),
                count => format!(", {count} of {} inputs not finite", part.inputs),
            };
            let mean = short(part.mean_relative);
            writeln!(
                f,
                "  farthest {what}: {} (mean {mean}{not_finite})",
                part.name
            )?;
        }
    }
    for reason in &found.reasons {
        writeln!(f, "  why: {reason}")?;
    }
    writeln!(f, "  what to do: {}", advice(reference, side, found))
}

/// Returns the part with the most non-finite answers; among these, the one with the greatest
/// difference.
fn farthest(parts: &[ParityPart]) -> Option<&ParityPart> {
    let key = |part: &&ParityPart| (part.non_finite, part.mean_relative);
    parts.iter().max_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    })
}

/// Returns advice about a difference.
fn advice(reference: &ParitySide, side: &ParitySide, found: &Comparison) -> &'static str {
    if reference.non_finite + side.non_finite > 0 {
        return "look for overflow (of half precision at 65,504), logarithms, roots and divisions: one NaN spreads to everything computed from it";
    }
    let greatest = [&found.embedding, &found.scores];
    let greatest = greatest.into_iter().flatten();
    let greatest = greatest.fold(0.0, |most: f64, one| most.max(one.greatest_relative));
    let is_beyond = |one: &Option<AnswerDifference>| {
        one.is_some_and(|difference| {
            difference.mean_relative > found.limits.mean_relative_difference
        })
    };
    if reference.quantized != side.quantized
        && found.scores.is_some()
        && is_beyond(&found.embedding)
        && !is_beyond(&found.scores)
    {
        return "the scores agree, so the fault is at the embedding's own output: tools that quantise an output together with the Relu after it cut off all values below 0 (keep that output in float, or remove the Relu)";
    }
    if reference.quantized != side.quantized {
        return "calibrate with pictures such as these (`edgegait sweep`) and per-channel scales, look for an output whose range the calibration has clipped, and run both models on another runtime to separate the effect of rounding from that of the runtime";
    }
    if side.quantized && reference.runtime == side.runtime {
        return "the files have different weights or scales (a wrong scale or zero point of one layer suffices): compare each with the float model on this runtime";
    }
    if side.quantized {
        return "run the float model on both runtimes: if it agrees, one of them computes 8-bit operations differently (7-bit weights avoid the saturation of processors without VNNI)";
    }
    if reference.model == side.model && greatest <= HALF_PRECISION {
        return "half precision explains this difference: if it is intended, allow it with --max-relative-difference 0.02 --max-mean-relative-difference 0.02";
    }
    if reference.model == side.model {
        return "a third side (--runtime rten, ort, ort:PROVIDER) shows which of them is wrong; do not deploy before that is known";
    }
    "the files have different weights or operations: if that is intended, allow it with --max-relative-difference and --max-mean-relative-difference"
}

/// Formats a number with three digits, without trailing zeros.
fn short(number: f64) -> String {
    match number {
        0.0 => "0".into(),
        _ if (0.001..1000.0).contains(&number) => {
            let digits = 2 - number.log10().floor() as i32;
            let text = format!("{number:.*}", usize::try_from(digits).unwrap_or(0));
            let is_fraction = text.contains('.');
            let trimmed = text.trim_end_matches('0').trim_end_matches('.');
            if is_fraction {
                trimmed.into()
            } else {
                text.clone()
            }
        }
        _ => format!("{number:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn numbers_are_written_with_three_digits() {
        for (number, text) in [
            (0.0, "0"),
            (1e-3, "0.001"),
            (0.5, "0.5"),
            (0.123456, "0.123"),
            (6.789, "6.79"),
            (100.0, "100"),
            (250.4, "250"),
            (1234.0, "1.2e3"),
            (4.26e-7, "4.3e-7"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(number), text);
        }
    }
}
