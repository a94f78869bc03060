//! Tables of results: boards, then models, a column each, as plain text or Markdown.

use super::cells::{ResultRow, degrees, megabytes, of_clocks, per_second, some_of, us};
use super::results::{BenchResults, ModelResult};
use super::timing::Timing;
use super::video_pipeline;
use crate::files::text_table::Column::{Left, Right};
use crate::files::text_table::Table;
use crate::report::{grouped, microseconds, percent};

/// The format of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum TableFormat {
    /// Aligned columns.
    #[default]
    Text,
    /// Tables of Markdown.
    Markdown,
}

impl TableFormat {
    /// Returns the format's name in flags.
    #[must_use]
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Markdown => "markdown",
        }
    }
}

/// Results and their name, which also appears in the headings of their models unless it is empty.
pub(crate) struct ResultColumn<'a> {
    /// The name, such as that of the results' file.
    pub name: &'a str,
    /// The results.
    pub results: &'a BenchResults,
}

/// The cell of an unknown value.
const ABSENT: &str = "-";

/// Renders all results side by side, without rows that are empty in all columns.
#[must_use]
pub(crate) fn render(columns: &[ResultColumn<'_>], format: TableFormat) -> String {
    let boards = columns
        .iter()
        .map(|column| (column.name.to_owned(), column.results));
    let heading = |model: &str, board: &str| match board {
        "" => model.to_owned(),
        name => format!("{model} {name}"),
    };
    let models = columns.iter().flat_map(|ResultColumn { name, results }| {
        let models = results.models.iter();
        models.map(|model| (heading(&named(model, results), name), model))
    });
    let of_model = |(name, model): (String, &ModelResult)| {
        [
            (!model.batches.is_empty()).then(|| by_batch(&name, model, format)),
            (!model.lengths.is_empty()).then(|| by_length(&name, model, format)),
            (!model.operators.is_empty()).then(|| by_operator(&name, model, format)),
        ]
    };
    let more: Vec<String> = models.clone().flat_map(of_model).flatten().collect();
    let paths = columns.iter().flat_map(|ResultColumn { name, results }| {
        let paths = results.paths.iter();
        paths.map(|path| (heading(&path.name, name), path))
    });
    let mut tables = vec![side_by_side(boards, &BOARD_ROWS, format)];
    if columns
        .iter()
        .any(|column| !column.results.models.is_empty())
    {
        tables.push(side_by_side(models, &MODEL_ROWS, format));
    }
    tables.extend(more);
    if columns
        .iter()
        .any(|column| !column.results.paths.is_empty())
    {
        tables.push(side_by_side(paths, &video_pipeline::ROWS, format));
    }
    tables.join("\n")
}

/// Returns a model's name, with its number of threads if it was measured with several.
pub(super) fn named(model: &ModelResult, results: &BenchResults) -> String {
    let is_again = |other: &&ModelResult| other.name == model.name;
    match (
        results.models.iter().filter(is_again).count(),
        model.threads,
    ) {
        (1, _) => model.name.clone(),
        (_, 1) => format!("{}, 1 thread", model.name),
        (_, threads) => format!("{}, {threads} threads", model.name),
    }
}

/// Renders the costs of batches of several sizes, a row each.
fn by_batch(name: &str, model: &ModelResult, format: TableFormat) -> String {
    let mut table = Table::new(&[Left(0), Right(0)]).with_gap(2);
    let headings = [
        name,
        "p50 of a batch, us",
        "us per inference",
        "a second",
        "windows apart",
        "peak memory",
    ];
    table.row(headings);
    for batch in model.offline.iter().chain(&model.batches) {
        let timing = &batch.timing;
        let cells = [
            Some(format!("batch: {}", batch.batch)),
            us(timing.times.p50_us),
            us(timing.times.p50_us / batch.batch as f64),
            Some(per_second(timing.throughput)),
            spread(timing),
            batch.peak_rss_bytes.map(megabytes),
        ];
        table.row(cells.map(|cell| cell.unwrap_or(ABSENT.into())));
    }
    written(&table, format)
}

/// Renders the times of operators, the longest first.
fn by_operator(name: &str, model: &ModelResult, format: TableFormat) -> String {
    let mut table = Table::new(&[Left(0), Left(0), Left(0), Right(0)]).with_gap(2);
    table.row([name, "by", "in", "operators", "us", "share"]);
    let all: f64 = model
        .operators
        .iter()
        .map(|operator| operator.mean_us)
        .sum();
    let mut sorted: Vec<_> = model.operators.iter().collect();
    sorted.sort_by(|a, b| b.mean_us.total_cmp(&a.mean_us));
    for one in sorted {
        table.row([
            one.ran.operator.clone(),
            one.ran.provider.replace("ExecutionProvider", ""),
            one.ran.arithmetic.name().to_owned(),
            one.ran.count.to_string(),
            microseconds(one.mean_us, ","),
            format!("{} %", percent(one.mean_us / all.max(f64::MIN_POSITIVE))),
        ]);
    }
    written(&table, format)
}

fn written(table: &Table<'_>, format: TableFormat) -> String {
    match format {
        TableFormat::Text => table.to_string(),
        TableFormat::Markdown => table.markdown(),
    }
}

/// Renders the costs of inputs of several lengths, a row each.
fn by_length(name: &str, model: &ModelResult, format: TableFormat) -> String {
    let mut table = Table::new(&[Left(0), Right(0)]).with_gap(2);
    let headings = [
        name,
        "multiply-accumulates",
        "p50, us",
        "p90, us",
        "a second",
        "peak memory",
        "of that, runtime and model",
        "inferences",
    ];
    table.row(headings);
    for length in &model.lengths {
        let timing = &length.timing;
        let made = timing.extent.as_ref().map(|extent| {
            let all: Vec<String> = extent.inferences.iter().map(ToString::to_string).collect();
            all.join(" + ")
        });
        let cells = [
            Some(format!("frames: {}", length.frames)),
            length.macs.map(|macs| grouped(macs, ",")),
            us(timing.times.p50_us),
            timing.times.p90_us.and_then(us),
            Some(per_second(timing.throughput)),
            length.peak_rss_bytes.map(megabytes),
            length.peak_rss_over_baseline_bytes.map(megabytes),
            made,
        ];
        table.row(cells.map(|cell| cell.unwrap_or(ABSENT.into())));
    }
    written(&table, format)
}

/// Renders a row of headings and a row for each label.
pub(super) fn side_by_side<'a, T: 'a>(
    columns: impl Iterator<Item = (String, &'a T)>,
    rows: &[ResultRow<T>],
    format: TableFormat,
) -> String {
    let (mut headings, columns): (Vec<String>, Vec<&T>) = columns.unzip();
    // A single column of text is more readable left-aligned.
    let aligned = match (format, columns.len()) {
        (TableFormat::Text, 1) => [Left(0); 2],
        _ => [Left(0), Right(0)],
    };
    let mut table = Table::new(&aligned).with_gap(2);
    headings.insert(0, String::new());
    table.row(headings);
    for (label, cell) in rows {
        let cells: Vec<Option<String>> = columns.iter().map(|column| cell(column)).collect();
        if cells.iter().flatten().any(|cell| !cell.is_empty()) {
            let cells = cells.into_iter().map(|cell| cell.unwrap_or(ABSENT.into()));
            table.row([(*label).to_owned()].into_iter().chain(cells));
        }
    }
    written(&table, format)
}

const BOARD_ROWS: [ResultRow<BenchResults>; 10] = [
    ("date", |r| Some(r.date.clone())),
    ("board", |r| r.board.model.clone()),
    ("SoC", |r| r.board.soc.clone()),
    ("processors", |r| {
        let groups = r.board.cpus.iter().map(|group| {
            let name = group.name.as_deref().or(group.part.as_deref());
            let clock = group.max_khz.map(|khz| format!(" at {} MHz", khz / 1000));
            let count = group.cpus.numbers().len();
            format!(
                "{count} x {}{}",
                name.unwrap_or("?"),
                clock.unwrap_or_default()
            )
        });
        some_of(groups)
    }),
    ("processors used", |r| {
        r.board.affinity.as_ref().map(ToString::to_string)
    }),
    ("features", |r| Some(r.board.features.join(" "))),
    ("memory", |r| r.board.ram_bytes.map(megabytes)),
    ("kernel", |r| r.board.kernel.clone()),
    ("load of other processes", |r| {
        r.load_of_others
            .map(|share| format!("{} %", percent(share)))
    }),
    ("EdgeGait", |r| {
        let build = r
            .header
            .settings
            .get("build")
            .and_then(|build| build.as_str());
        Some(format!(
            "{} {} {}",
            r.header.version,
            build.unwrap_or("?"),
            r.board.architecture
        ))
    }),
];

const MODEL_ROWS: [ResultRow<ModelResult>; 43] = [
    ("runtime", |m| Some(m.runtime.to_string())),
    ("threads", |m| Some(m.threads.to_string())),
    ("input", |m| {
        let sides: Vec<String> = m.input.iter().map(ToString::to_string).collect();
        Some(sides.join("x"))
    }),
    ("file, bytes", |m| Some(grouped(m.bytes, ","))),
    ("parameters", |m| Some(grouped(m.params, ","))),
    ("multiply-accumulates", |m| {
        m.macs.map(|macs| grouped(macs, ","))
    }),
    ("runtime start, ms", |m| {
        Some(format!("{:.2}", m.runtime_load_ms))
    }),
    ("load, ms", |m| Some(format!("{:.2}", m.load_ms))),
    ("first inference, ms", |m| {
        Some(format!("{:.3}", m.first_ms))
    }),
    ("one at a time: min, us", |m| us(m.single.times.min_us)),
    ("mean", |m| us(m.single.times.mean_us)),
    ("standard deviation", |m| us(m.single.times.sd_us)),
    ("p50", |m| us(m.single.times.p50_us)),
    ("p90", |m| us(m.single.times.p90_us?)),
    ("p95", |m| us(m.single.times.p95_us?)),
    ("p99", |m| us(m.single.times.p99_us?)),
    ("p99.9", |m| us(m.single.times.p999_us?)),
    ("max", |m| us(m.single.times.max_us)),
    ("inferences a second", |m| {
        Some(per_second(m.single.throughput))
    }),
    ("spread of windows", |m| spread(&m.single)),
    ("cut: one at a time", |m| m.single.cut()),
    ("in batches of", |m| {
        m.offline.as_ref().map(|it| it.batch.to_string())
    }),
    ("cut: batch size", |m| {
        let planned = m.offline.as_ref()?.batch_planned?;
        let is_cut = planned > m.offline.as_ref()?.batch;
        is_cut.then(|| format!("not {planned}"))
    }),
    ("p50 of a batch, us", |m| {
        us(m.offline.as_ref()?.timing.times.p50_us)
    }),
    ("inferences a second, batches", |m| {
        Some(per_second(m.offline.as_ref()?.timing.throughput))
    }),
    ("spread of windows, batches", |m| {
        spread(&m.offline.as_ref()?.timing)
    }),
    ("cut: batches", |m| m.offline.as_ref()?.timing.cut()),
    ("drawing one input: p50, us", |m| {
        us(m.parts.preprocessing.times.p50_us)
    }),
    ("drawing and inference: p50, us", |m| {
        us(m.parts.end_to_end.times.p50_us)
    }),
    ("cut: drawing, with inference", |m| {
        some_of(
            [m.parts.preprocessing.cut(), m.parts.end_to_end.cut()]
                .into_iter()
                .flatten(),
        )
    }),
    ("ONNX Runtime alone: p50, us", |m| {
        us(m.bare.as_ref()?.timing.times.p50_us)
    }),
    ("overhead of EdgeGait", |m| {
        Some(format!("{:+.1} %", 100.0 * m.bare.as_ref()?.overhead))
    }),
    ("the same, outputs reused: p50, us", |m| {
        us(m.bare.as_ref()?.reusing_p50_us)
    }),
    ("overhead of EdgeGait over that", |m| {
        Some(format!(
            "{:+.1} %",
            100.0 * m.bare.as_ref()?.overhead_reusing
        ))
    }),
    ("peak memory", |m| m.peak_rss_bytes.map(megabytes)),
    ("of that, runtime and model", |m| {
        m.peak_rss_over_baseline_bytes.map(megabytes)
    }),
    ("peak memory, batches", |m| {
        m.offline.as_ref()?.peak_rss_bytes.map(megabytes)
    }),
    ("energy, mJ: one, batched", |m| {
        let energy = m.energy.as_ref()?;
        let all = [Some(energy.single_mj), energy.offline_mj];
        some_of(all.into_iter().flatten().map(|mj| format!("{mj:.3}")))
    }),
    ("rank-1 (95 %)", |m| {
        let a = m.accuracy.as_ref()?;
        let (low, high) = a.intervals.shown();
        let [rank1, low, high] = [a.rank1, low, high].map(percent);
        Some(format!("{rank1} % ({low} - {high})"))
    }),
    ("cut: viewpoints of rank-1", |m| {
        let a = m.accuracy.as_ref()?;
        let planned = a
            .viewpoints_planned
            .filter(|&planned| planned > a.viewpoints)?;
        Some(format!("{} of {planned}", a.viewpoints))
    }),
    ("load of other processes meanwhile", |m| {
        m.others_busy.map(|share| format!("{} %", percent(share)))
    }),
    ("clock: start, end", |m| of_clocks(&m.conditions)),
    ("temperature, C: start, highest, end", |m| {
        degrees(&m.conditions)
    }),
];

/// Returns the spread of windows; none for a single window.
fn spread(timing: &Timing) -> Option<String> {
    let is_known = timing.window_mean_us.len() > 1;
    is_known.then(|| format!("{} %", percent(timing.spread)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_empty_rows_are_left_out() {
        let rows: [ResultRow<[Option<&str>; 3]>; 3] = [
            ("time", |of| of[0].map(str::to_owned)),
            ("energy", |of| of[1].map(str::to_owned)),
            ("heat", |of| of[2].map(str::to_owned)),
        ];
        let columns = [
            ("a".to_owned(), &[Some("1.25"), None, None]),
            ("b".to_owned(), &[Some("10"), None, Some("45.0")]),
        ];
        let text = side_by_side(columns.clone().into_iter(), &rows, TableFormat::Text);
        assert_eq!(
            text,
            "         a     b\ntime  1.25    10\nheat     -  45.0\n"
        );
        let alone = side_by_side(columns.into_iter().take(1), &rows, TableFormat::Text);
        assert_eq!(alone, "      a\ntime  1.25\n");
    }
}
