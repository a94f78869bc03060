//! Text that may come from a stranger's file, as people see it: nothing in it moves a cursor, sets a
//! colour or reorders the words around it.

use std::borrow::Cow;

/// Returns whether a terminal or a page acts upon a character instead of showing it: controls (C0,
/// DEL and C1), and the controls of direction of Unicode (UAX 9, section 2).
pub(crate) fn is_hidden(letter: char) -> bool {
    letter.is_control()
        || matches!(letter, '\u{61c}' | '\u{200e}' | '\u{200f}')
        || matches!(letter, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Returns a text with hidden characters as escapes, as in `\u{1b}`. New lines and tabs stay.
pub(crate) fn visible(text: &str) -> Cow<'_, str> {
    escaped(text, |letter| {
        is_hidden(letter) && !matches!(letter, '\n' | '\t')
    })
}

/// Returns a name with hidden characters as escapes, new lines too, so that it stays in its line.
pub(crate) fn visible_name(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden)
}

/// Returns a text as a string of TOML with hidden characters as escapes, as in `\u001b`.
pub(crate) fn visible_toml(text: &str) -> String {
    if !text.contains(is_hidden) {
        return toml::Value::from(text).to_string();
    }
    // What JSON escapes, TOML reads alike.
    let json = serde_json::Value::from(text).to_string();
    let letters = json.chars().map(|letter| match is_hidden(letter) {
        true => format!("\\u{:04x}", u32::from(letter)),
        false => letter.to_string(),
    });
    letters.collect()
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 8);
    for letter in text.chars() {
        if is_escaped(letter) {
            out.extend(letter.escape_default());
        } else {
            out.push(letter);
        }
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_of_toml_is_the_same_text_without_hidden_characters() {
        let text = "models[\u{9b}31m \"x\" \u{202e}\u{7f}\n].p50_us";
        let written = visible_toml(text);
        assert!(!written.contains(is_hidden), "{written:?}");
        let read: toml::Table = toml::from_str(&format!("figure = {written}")).expect("TOML");
        assert_eq!(read["figure"].as_str(), Some(text));
    }

    #[test]
    fn what_a_terminal_acts_upon_is_escaped_and_names_of_people_are_not() {
        for (text, shown) in [
            ("\u{1b}[31mred\u{7}", "\\u{1b}[31mred\\u{7}"),
            ("\u{9b}31m\u{7f}\r\u{8}", "\\u{9b}31m\\u{7f}\\r\\u{8}"),
            (
                "a\u{202e}b\u{2066}c\u{2069}",
                "a\\u{202e}b\\u{2066}c\\u{2069}",
            ),
            ("\u{61c}\u{200e}\u{200f}", "\\u{61c}\\u{200e}\\u{200f}"),
            ("Zoë Müller 中村 नेहा أحمد", "Zoë Müller 中村 नेहा أحمد"),
            ("two\nlines\tand more", "two\nlines\tand more"),
        ] {
            assert_eq!(visible(text), shown);
        }
        assert_eq!(visible_name("a\nerror: b\tc"), "a\\nerror: b\\tc");
    }
}
