//! Numbers of a table with a decimal point or a decimal comma.

/// How the columns of a table are separated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Delimiter {
    Comma,
    Semicolon,
    Tab,
}

impl Delimiter {
    /// The delimiter of a file, by its first row: a semicolon or a tab if there is one.
    pub fn of(text: &str) -> Self {
        let first = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#'));
        match first {
            Some(line) if line.contains(';') => Self::Semicolon,
            Some(line) if line.contains('\t') => Self::Tab,
            _ => Self::Comma,
        }
    }

    /// The letter that separates two cells.
    pub fn byte(self) -> u8 {
        match self {
            Self::Comma => b',',
            Self::Semicolon => b';',
            Self::Tab => b'\t',
        }
    }
}

/// Reads numbers that all have the same decimal mark.
#[derive(Debug)]
pub struct Numbers {
    delimiter: Delimiter,
    /// The mark of the first number that has one.
    mark: Option<char>,
}

impl Numbers {
    /// Of a table with this delimiter.
    pub fn new(delimiter: Delimiter) -> Self {
        Self { delimiter, mark: None }
    }

    /// The number in a cell.
    ///
    /// # Errors
    /// Why there is none.
    pub fn read(&mut self, cell: &str) -> Result<f64, String> {
        let mark = cell.chars().find(|letter| matches!(letter, '.' | ','));
        let with_point = match mark {
            Some(',') if self.delimiter != Delimiter::Comma => cell.replacen(',', ".", 1),
            _ => cell.to_owned(),
        };
        let number = with_point.parse().map_err(|_| format!("{cell:?} is not a number"))?;
        match (mark, self.mark) {
            (Some(mark), Some(first)) if mark != first => Err(format!(
                "{cell:?} has the decimal mark {mark:?}, must have {first:?} as the numbers before"
            )),
            _ => {
                self.mark = self.mark.or(mark);
                Ok(number)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_row_that_is_no_comment_decides_the_delimiter() {
        for (text, expected) in [
            ("# a;b\n1,2\n", Delimiter::Comma),
            ("\n0,5;1\n", Delimiter::Semicolon),
            ("1,5\t2,5\n", Delimiter::Tab),
            ("1\n2;3\n", Delimiter::Comma),
            ("", Delimiter::Comma),
        ] {
            assert_eq!(Delimiter::of(text), expected, "{text:?}");
        }
    }

    #[test]
    fn a_decimal_comma_is_read_where_commas_do_not_separate_and_marks_are_not_mixed() {
        let mut numbers = Numbers::new(Delimiter::Semicolon);
        assert_eq!(numbers.read("-1,5e-3"), Ok(-1.5e-3));
        assert_eq!(numbers.read("2"), Ok(2.0));
        assert!(numbers.read("1,234,5").is_err());
        assert!(numbers.read("1.5").is_err_and(|reason| reason.contains("decimal mark")));
        assert!(Numbers::new(Delimiter::Comma).read("1,5").is_err());
    }
}
