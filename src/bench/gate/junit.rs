//! The report as JUnit XML, which CI systems read.
//!
//! The dialect is that of Jenkins and the Maven Surefire plugin (its `surefire-test-report.xsd`). A
//! missed limit is a failure, and an undecided one an error.

use super::judge::GateOutcome;
use super::report::{GateLine, GateReport};
use crate::error::is_hidden;
use std::fmt::Write as _;

/// The beginning of every JUnit file of this command.
pub(crate) const JUNIT_START: &str =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"edgegait gate\"";

impl GateReport {
    /// Returns one suite with a case for each limit.
    pub(crate) fn junit(&self) -> String {
        let counts = format!(
            "tests=\"{}\" failures=\"{}\" errors=\"{}\"",
            self.limits.len(),
            self.count(GateOutcome::Missed),
            self.count(GateOutcome::CannotTell)
        );
        let mut text =
            format!("{JUNIT_START} {counts}>\n  <testsuite name=\"edgegait gate\" {counts}>\n");
        for line in &self.limits {
            let tag = match line.outcome {
                GateOutcome::Holds => None,
                GateOutcome::Missed => Some("failure"),
                GateOutcome::CannotTell => Some("error"),
            };
            let case = format!(
                "    <testcase classname=\"{}\" name=\"{}\"",
                escaped(&line.figure),
                escaped(&format!("{}: {}", line.name, line.limit))
            );
            // Writing to a string cannot fail.
            let _ = match tag {
                None => writeln!(text, "{case}/>"),
                Some(tag) => writeln!(
                    text,
                    "{case}>\n      <{tag} type=\"{}\" message=\"{}\"/>\n    </testcase>",
                    line.outcome.name(),
                    escaped(&message(line))
                ),
            };
        }
        text + "  </testsuite>\n</testsuites>\n"
    }
}

fn message(line: &GateLine) -> String {
    let beside = match line.beside_text() {
        text if text.is_empty() => text,
        text => format!(", baseline {text}"),
    };
    let said = match line.remarks().collect::<Vec<_>>().join("; ") {
        text if text.is_empty() => text,
        text => format!(": {text}"),
    };
    format!(
        "found {}, limit {}{beside}{said}",
        line.found_text(),
        line.limit
    )
}

/// Escapes text for an attribute; characters that XML 1.0 does not allow are left out.
fn escaped(text: &str) -> String {
    let mut out = String::new();
    for letter in text.chars() {
        match letter {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '\n' | '\t' | '\r' => out.push(' '),
            _ if is_hidden(letter) || matches!(letter, '\u{fffe}' | '\u{ffff}') => {}
            _ => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_xml_does_not_hold_is_escaped_or_left_out() {
        assert_eq!(
            escaped("a<b>&\"c\"\n\u{1}d"),
            "a&lt;b&gt;&amp;&quot;c&quot; d"
        );
    }
}
