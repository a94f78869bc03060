//! The report: one self-contained HTML page.
//!
//! It has no scripts, fonts or links, so that it can be archived, sent by e-mail, read on a phone
//! and printed. All external text is escaped.

use std::fs;
use std::io::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::GrayImage;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::Value;

use super::summary::{finding, summary};
use super::viewpoints::{recognizer, small_multiples};
use super::{THIN, chart, cmc_roc, grouped, paired, people, percent, png, speed_error};
use crate::draw::template::Template;
use crate::error::{Error, ReportError, Result, visible};
use crate::evaluate::results::ScoreResults;
use crate::files::{ResultHeader, write_atomically};

const CSS: &str = concat!(include_str!("style.css"), include_str!("chart.css"));

/// A template to show, and its description.
#[derive(Clone, Debug)]
pub(crate) struct TemplateSample {
    /// A few words, such as `s03, 90° / 0°`.
    pub caption: String,
    /// Kind of template.
    pub template: Template,
    /// Rows of the image, or total rows of several images below each other.
    pub rows: usize,
    /// Columns of the image.
    pub columns: usize,
    /// The image, row by row from the top.
    pub pixels: Vec<u8>,
}

/// Writes the page of [`page`] atomically, and creates its folder if necessary.
///
/// # Errors
///
/// If the file cannot be written.
pub(crate) fn write_page(
    path: impl AsRef<Path>,
    results: &ScoreResults,
    samples: &[TemplateSample],
) -> Result<()> {
    let path = path.as_ref();
    if let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        fs::create_dir_all(folder).map_err(|source| Error::io(folder, source))?;
    }
    let page = page(results, samples)?;
    write_atomically(path, |file| {
        file.write_all(page.as_bytes())
            .map_err(|e| Error::io(path, e))
    })
}

/// Returns the results as a self-contained HTML document.
///
/// # Errors
///
/// If a picture cannot be encoded, which only happens without memory.
pub(crate) fn page(results: &ScoreResults, samples: &[TemplateSample]) -> Result<String> {
    let viewpoints = results
        .recognizers
        .iter()
        .map(|result| result.by_viewpoint.len())
        .max()
        .unwrap_or(0);
    let title = match viewpoints {
        0 => "Gait recognition".to_owned(),
        1 => "Gait recognition from one viewpoint".to_owned(),
        many => format!(
            "Gait recognition from {} viewpoints",
            grouped(many as u64, THIN)
        ),
    };
    let pictures = samples.iter().map(sample).collect::<Result<Vec<_>>>()?;
    let body = html! {
                header {
                    h1 { (title) }
                    (facts(results))
                    (lead())
                    (finding(results))
                    (warnings(results))
                }
                main {
                    @if let Some(picture) = speed_error::figure(results) {
                        h2 { "Accuracy against time" }
                        (picture)
                    }
                    (summary(results))
                    (small_multiples(&results.recognizers))
                    (paired::section(results))
                    (people::section(results))
                    @if let Some(chart) = chart::angles(&results.recognizers) {
                        h2 { "Rank-1 by angle from the training viewpoints" }
                        (chart)
                    }
                    @if let Some(charts) = cmc_roc::charts(&results.recognizers) {
                        h2 { "Identification and verification" }
                        (charts)
                    }
                    @for result in &results.recognizers {
                        details open[results.recognizers.len() == 1] {
                            summary { h2 { (result.name) ": all numbers" } }
                            (recognizer(result, &results.recognizers))
                        }
                    }
                    @if let Some(first) = samples.first() {
                        h2 { "What the recognizers see" }
                        p.quiet { (name(first.template)) "s, " (first.rows) " rows by "
                            (first.columns) " columns, enlarged"
                            @if first.template == Template::Gei {
                                ": the mean of the "
                                "silhouettes of a gait cycle. White is where the walker always is"
                            } "." }
                        div.samples { @for picture in &pictures { (picture) } }
                    }
                    (reading())
                    (provenance(&results.header))
                }
    };
    Ok(document(&title, &body))
}

/// Returns a self-contained HTML document with this title.
pub(super) fn document(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) " · EdgeGait" }
                style { (PreEscaped(CSS)) }
            }
            body { (body) }
        }
    };
    visible(&page.into_string()).into_owned()
}

fn facts(results: &ScoreResults) -> Markup {
    let header = &results.header;
    html! {
        p.facts {
            "edgegait " (header.version) " " (header.command) " · seed " (header.seed)
            " · " (grouped(results.geis, THIN))
            @match header.settings.get("template") {
                None => " GEIs of ",
                Some(_) => " templates of ",
            }
            (grouped(results.silhouettes, THIN)) " silhouettes"
            @if let Some(share) = results.clipped_share {
                " · " (percent(share)) " % of the figures' area cut off at the edges of the image"
            }
            @if let Some(time) = results.time { " · " (format!("{:.1}", time.seconds)) "\u{a0}s" }
        }
    }
}

fn lead() -> Markup {
    html! {
        p.lead {
            "Recognizers were shown silhouettes of walking people, one by one or averaged over a gait "
            "cycle (Gait Energy Images, GEI), and had to find each walker, the probe, among enrolled "
            "people, the gallery. This page shows how often each was right, from which viewpoints, and "
            "how long an answer took."
        }
    }
}

fn warnings(results: &ScoreResults) -> Markup {
    let broken = results
        .recognizers
        .iter()
        .filter(|result| result.non_finite > 0);
    let broken: Vec<_> = broken.collect();
    html! {
        @if !results.header.warnings.is_empty() || !broken.is_empty() {
            section.warnings {
                strong { "Before trusting the numbers" }
                ul {
                    @for warning in &results.header.warnings { li { (warning) } }
                    @for result in broken {
                        li { (result.name) ": " (grouped(result.non_finite, THIN))
                            " outputs were not finite and count as misses" }
                    }
                }
            }
        }
    }
}

/// Returns the name of a template.
fn name(template: Template) -> String {
    match template {
        Template::Gei => "Gait Energy Image".to_owned(),
        other => format!("{} template", other.name()),
    }
}

fn sample(sample: &TemplateSample) -> Result<Markup> {
    let (rows, columns) = (sample.rows, sample.columns);
    let picture = GrayImage::from_raw(columns as u32, rows as u32, sample.pixels.clone())
        .ok_or(ReportError::Bytes { rows, columns })?;
    let source = format!("data:image/png;base64,{}", STANDARD.encode(png(&picture)?));
    Ok(html! {
        figure {
            img src=(source) width=(columns * 3) height=(rows * 3)
                alt=(format!("{}: {}", name(sample.template), sample.caption));
            figcaption { (sample.caption) }
        }
    })
}

fn reading() -> Markup {
    html! {
        h2 { "How to read this" }
        p { strong { "Rank-1" } " is the share of probes whose best match is the right person. Ties go "
            "to the person listed first; an output that is not finite is a miss." }
        p { strong { "The interval" } " \"over people\" is a 95 % interval that resamples people (cluster "
            "bootstrap), because views of one walk are not independent. Where hits per person are not known, "
            "or all probes show one person, it is Wilson's interval, which treats probes as independent." }
        p { strong { "mAP and mINP" } " leave out probes whose person is not in the gallery, as OpenGait "
            "does; " strong { "EER, AUC and TAR" } " treat every distance as a claim of identity. A "
            "question mark marks rates based on fewer than 30 false accepts; a dash, too few impostor pairs." }
        p { strong { "Viewpoints" } ": azimuth 0 is a camera in front of the walker, 90 on the walker's "
            "left, 180 behind; elevation 0 is level, 90 straight above, where all azimuths are one "
            "direction and differ by roll." }
        p { strong { "Times" } " are from one machine and vary between runs; all other numbers follow "
            "from the inputs, settings and seed below." }
    }
}

pub(super) fn provenance(header: &ResultHeader) -> Markup {
    html! {
        h2 { "Settings and inputs" }
        table.keys { tbody {
            tr { th scope="row" { "seed" } td { code { (header.seed) } } }
            @for (name, value) in &header.settings {
                tr { th scope="row" { (name) } td { code { (plain(value)) } } }
            }
        } }
        @if !header.inputs.is_empty() {
            h3 { "Inputs, with SHA-256" }
            table.keys { tbody { @for input in &header.inputs {
                tr { td { (input.path) br; code.quiet { (input.sha256) } } }
            } } }
        }
    }
}

fn plain(value: &Value) -> String {
    value
        .as_str()
        .map_or_else(|| value.to_string(), str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::results::tests::{result_of, results_of};
    use crate::evaluate::results::{Latency, RecognizerResult};
    use crate::files::InputFile;

    fn grid() -> RecognizerResult {
        RecognizerResult {
            latency: Latency::from_samples(&[5.0]),
            ..crate::report::summary::tests::grid()
        }
    }

    #[test]
    fn a_page_needs_nothing_else() {
        let samples = [TemplateSample {
            caption: "s01".into(),
            template: Template::Gei,
            rows: 64,
            columns: 44,
            pixels: vec![128; 64 * 44],
        }];
        let page = page(&results_of(vec![grid()]), &samples).unwrap();
        assert!(page.starts_with("<!DOCTYPE html><html lang=\"en\">"));
        for outside in ["http://", "https://", "<script", "<link", "@import", "url("] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert!(page.contains("src=\"data:image/png;base64,iVBORw0KGgo"));
        assert!(page.contains("64 rows by 44 columns") && page.contains("width=\"132\""));
        assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
    }

    #[test]
    fn text_from_outside_is_escaped() {
        let evil = "<script>alert(\"1\")</script>'&";
        let mut result = grid();
        result.name = evil.into();
        result.runtime.version = evil.into();
        let mut results = results_of(vec![result]);
        results.header.warnings.push(evil.into());
        results
            .header
            .settings
            .insert(evil.into(), Value::from(evil));
        results.header.inputs.push(InputFile {
            path: evil.into(),
            sha256: evil.into(),
        });
        let page = page(
            &results,
            &[TemplateSample {
                caption: evil.into(),
                template: Template::Gei,
                rows: 50,
                columns: 30,
                pixels: vec![0; 1500],
            }],
        )
        .unwrap();
        assert!(!page.contains("<script"));
        assert!(
            !page.contains("alert(\"1\")"),
            "a quote would end an attribute"
        );
        assert!(page.contains("&lt;script&gt;alert(&quot;1&quot;)"));
    }

    #[test]
    fn scattered_viewpoints_are_dots_and_a_table() {
        let list: Vec<_> = (0..26)
            .map(|i| (f64::from(i) * 3.5, f64::from(i) - 9.0, 1, 2))
            .collect();
        let page = page(&results_of(vec![result_of(&list)]), &[]).unwrap();
        assert_eq!(page.matches("class=\"dot\"").count(), 26);
        assert!(page.contains("<td>3.5</td><td>-8</td><td>2</td>"));
        assert!(page.contains("; 7 viewpoints are in no band"));
        let few = result_of(&[(12.5, 3.0, 1, 2), (77.0, -9.0, 2, 2)]);
        let page = super::page(&results_of(vec![few]), &[]).unwrap();
        assert!(page.contains("<td>12.5</td>") && !page.contains("class=\"bands\""));
    }

    #[test]
    fn an_empty_result_is_still_a_page() {
        let empty = page(&results_of(vec![]), &[]).unwrap();
        assert!(empty.contains("Nothing was scored."));
        assert!(page(&results_of(vec![result_of(&[])]), &[]).is_ok());
    }

    #[test]
    fn numbers_that_are_not_finite_are_warned_of() {
        let mut result = grid();
        result.non_finite = 3;
        let page = page(&results_of(vec![result]), &[]).unwrap();
        assert!(page.contains("pca-svm: 3 outputs were not finite and count as misses"));
    }

    #[test]
    fn a_page_is_written_into_a_new_folder() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("edgegait-report/index.html");
        write_page(&path, &results_of(vec![grid()]), &[]).unwrap();
        assert!(fs::read_to_string(path).unwrap().ends_with("</html>"));
    }
}
