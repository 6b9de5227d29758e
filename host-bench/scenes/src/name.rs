//! Texts from outside the program, as each kind of output takes them.

use std::path::Path;

use serde::Serialize;

/// The name of a scene, a file, an action or a column. It has no `Display`: an output takes it by the method of its kind.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Name(String);

impl Name {
    pub fn new(text: impl Into<String>) -> Self {
        Self(text.into())
    }

    /// The name of a file without its folder.
    pub fn of_file(file: &Path) -> Self {
        Self(file.file_name().unwrap_or_default().to_string_lossy().into_owned())
    }

    /// For a line of a comment, of a picture, of CSV or of a terminal: characters that break a line, control a terminal or
    /// change the direction of writing are escaped as in Rust.
    pub fn line(&self) -> String {
        let shown = |letter: char| match is_hidden(letter) {
            true => letter.escape_unicode().to_string(),
            false => letter.to_string(),
        };
        self.0.chars().map(shown).collect()
    }

    /// For the text and the attributes of HTML and SVG.
    pub fn html(&self) -> String {
        escaped(&self.line())
    }

    /// As one word of a shell, in one line.
    pub fn shell(&self) -> String {
        let text = &self.0;
        let is_plain = |letter: char| letter.is_alphanumeric() || "_-./:=,+@%".contains(letter);
        if text.chars().any(is_hidden) {
            return format!("$'{}'", self.octal());
        }
        match text {
            _ if !text.is_empty() && text.chars().all(is_plain) => text.clone(),
            _ if text.contains('\'') && !text.contains(['"', '$', '`', '\\', '!']) => format!("\"{text}\""),
            _ => format!("'{}'", text.replace('\'', "'\\''")),
        }
    }

    /// The bytes of hidden characters in octal digits.
    fn octal(&self) -> String {
        let mut all = String::new();
        for letter in self.0.chars() {
            if is_hidden(letter) {
                all.extend(letter.encode_utf8(&mut [0; 4]).bytes().map(|byte| format!("\\{byte:03o}")));
            } else {
                all.extend(['\'', '\\'].contains(&letter).then_some('\\'));
                all.push(letter);
            }
        }
        all
    }
}

/// Plain text of several lines as HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Whether a character breaks a line, controls a terminal or changes the direction of writing.
fn is_hidden(letter: char) -> bool {
    let direction = ['\u{61c}', '\u{200e}', '\u{200f}', '\u{2028}', '\u{2029}'];
    letter.is_control()
        || direction.contains(&letter)
        || ('\u{202a}'..='\u{202e}').contains(&letter)
        || ('\u{2066}'..='\u{2069}').contains(&letter)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_stays_in_its_line_and_its_word() {
        for (text, line, shell) in [
            ("node.toml", "node.toml", "node.toml"),
            ("a\nb\u{1b}[31m", "a\\u{a}b\\u{1b}[31m", "$'a\\012b\\033[31m'"),
            ("\u{202e}'\\", "\\u{202e}'\\", "$'\\342\\200\\256\\'\\\\'"),
            ("load={kind='ohm'}", "load={kind='ohm'}", "\"load={kind='ohm'}\""),
            ("$(touch x)'", "$(touch x)'", "'$(touch x)'\\'''"),
            ("", "", "''"),
        ] {
            let name = Name::new(text);
            assert_eq!((name.line().as_str(), name.shell().as_str()), (line, shell), "{text:?}");
        }
        assert_eq!(Name::new("<b a=\"\n\">").html(), "&lt;b a=&quot;\\u{a}&quot;&gt;");
    }
}
