//! The report as Markdown, for a pull request.

use super::judge::GateOutcome;
use super::report::GateReport;
use crate::error::is_hidden;
use crate::files::text_table::Column::Left;
use crate::files::text_table::Table;

/// The beginning of every Markdown file of this command.
pub(crate) const MARKDOWN_START: &str = "### EdgeGait gate: ";

impl GateReport {
    /// Returns a heading, a table, and the warnings.
    pub(crate) fn markdown(&self) -> String {
        let mut table = Table::new(&[Left(0)]);
        table.row(["", "figure", "found", "limit", "baseline"]);
        for line in &self.limits {
            let sign = match line.outcome {
                GateOutcome::Holds => "✅ holds".to_owned(),
                GateOutcome::Missed => "❌ **missed**".to_owned(),
                GateOutcome::CannotTell => "❔ cannot tell".to_owned(),
            };
            let name = if line.name == line.figure {
                format!("`{}`", line.name.replace('`', "'"))
            } else {
                plain(&line.name)
            };
            let named = std::iter::once(name)
                .chain(line.remarks().map(plain))
                .collect::<Vec<_>>()
                .join("<br>");
            table.row([
                sign,
                named,
                line.found_text(),
                line.limit.clone(),
                line.beside_text(),
            ]);
        }
        let mut text = format!("{MARKDOWN_START}{}\n\n{}", self.summary(), table.markdown());
        for warning in &self.header.warnings {
            text += &format!("\n> {}\n", plain(warning));
        }
        text
    }
}

/// Escapes the characters that Markdown or HTML would interpret.
fn plain(text: &str) -> String {
    let mut out = String::new();
    for letter in text.chars() {
        match letter {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '*' | '_' | '`' | '[' | ']' | '\\' => {
                out.push('\\');
                out.push(letter);
            }
            _ if is_hidden(letter) => out.push(' '),
            _ => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_of_markdown_are_kept_from_it() {
        assert_eq!(plain("<b> & a_b*\n"), "&lt;b&gt; &amp; a\\_b\\* ");
    }
}
