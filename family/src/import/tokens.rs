//! C and Java cut into words, numbers, texts and signs; comments are skipped.

use super::error::{ImportError, Problem};

/// Macros and casts that change nothing about a number.
const WORDS_AROUND_NUMBERS: [&str; 6] = ["UINT64_C", "UINT32_C", "uint64_t", "uint32_t", "unsigned", "long"];

/// A piece of the text, with its line counted from 1.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Token {
    pub kind: Kind,
    pub line: usize,
}

/// What a piece is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Word(String),
    /// A number as it is written, with its suffix.
    Number(String),
    /// A text without its quotes.
    Text(String),
    Sign(char),
}

/// A number of a list, with its line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Listed {
    pub value: u64,
    pub line: usize,
}

/// All tokens of a text, in their order.
pub(super) struct Tokens {
    pub all: Vec<Token>,
    pub last_line: usize,
}

impl Tokens {
    /// Cuts a text.
    pub(super) fn of(text: &str) -> Result<Tokens, ImportError> {
        let mut cutter = Cutter { letters: text.chars().collect(), place: 0, line: 1 };
        let mut all = Vec::new();
        while let Some(token) = cutter.next_token()? {
            all.push(token);
        }
        Ok(Tokens { all, last_line: cutter.line })
    }

    /// The kind of the token at a place; `None` behind the last.
    pub(super) fn kind(&self, place: usize) -> Option<&Kind> {
        self.all.get(place).map(|token| &token.kind)
    }

    /// The line of the token at a place; behind the last the last line.
    pub(super) fn line(&self, place: usize) -> usize {
        self.all.get(place).map_or(self.last_line, |token| token.line)
    }

    pub(super) fn is_word(&self, place: usize, word: &str) -> bool {
        matches!(self.kind(place), Some(Kind::Word(found)) if found == word)
    }

    /// Whether signs stand from a place on.
    pub(super) fn are_signs(&self, place: usize, signs: &str) -> bool {
        signs.chars().zip(place..).all(|(sign, place)| self.kind(place) == Some(&Kind::Sign(sign)))
    }

    /// The places of a word.
    pub(super) fn places_of<'a>(&'a self, word: &'a str) -> impl Iterator<Item = usize> + 'a {
        (0..self.all.len()).filter(move |&place| self.is_word(place, word))
    }

    /// The value of the number at a place, if one stands there.
    pub(super) fn number(&self, place: usize) -> Result<Option<Listed>, ImportError> {
        let Some(Kind::Number(text)) = self.kind(place) else { return Ok(None) };
        let line = self.line(place);
        match value_of(text) {
            Some(value) => Ok(Some(Listed { value, line })),
            None => {
                Err(Problem::Number { text: text.clone(), wanted: "a whole number of up to 64 bits" }
                    .at(line))
            }
        }
    }

    /// `[7] = value` behind a word at `place`: the number in brackets and the place of the value.
    pub(super) fn element(&self, place: usize) -> Result<Option<(u64, usize)>, ImportError> {
        if !(self.are_signs(place + 1, "[") && self.are_signs(place + 3, "]=")) {
            return Ok(None);
        }
        Ok(self.number(place + 2)?.map(|index| (index.value, place + 5)))
    }

    /// The numbers between the brace at `place` and the one that closes it, separated by commas. Casts and macros such
    /// as `UINT64_C(..)` are looked through.
    pub(super) fn list(&self, place: usize, what: &'static str) -> Result<Vec<Listed>, ImportError> {
        let (mut numbers, mut wants_comma) = (Vec::new(), false);
        for place in place + 1..self.all.len() {
            match &self.all[place].kind {
                Kind::Sign('}') => return Ok(numbers),
                Kind::Sign(',') => wants_comma = false,
                Kind::Number(_) if !wants_comma => {
                    numbers.extend(self.number(place)?);
                    wants_comma = true;
                }
                Kind::Sign('(' | ')') => {}
                Kind::Word(found) if WORDS_AROUND_NUMBERS.contains(&found.as_str()) => {}
                Kind::Number(found) => return Err(self.unexpected(place, found, "a comma")),
                Kind::Word(found) | Kind::Text(found) => {
                    return Err(self.unexpected(place, found, "a number"));
                }
                Kind::Sign(found) => return Err(self.unexpected(place, &found.to_string(), "a number")),
            }
        }
        Err(Problem::Truncated { what }.at(self.last_line))
    }

    fn unexpected(&self, place: usize, found: &str, wanted: &'static str) -> ImportError {
        Problem::Unexpected { found: found.to_owned(), wanted }.at(self.line(place))
    }
}

/// The value of a number in C or Java, whatever its suffix says about its type.
fn value_of(text: &str) -> Option<u64> {
    let text = text.to_lowercase().replace(['_', '\''], "");
    let digits = text.trim_end_matches(['u', 'l']);
    if let Some(digits) = digits.strip_prefix("0x") {
        return u64::from_str_radix(digits, 16).ok();
    }
    match digits.strip_prefix("0b") {
        Some(digits) => u64::from_str_radix(digits, 2).ok(),
        None => digits.parse().ok(),
    }
}

struct Cutter {
    letters: Vec<char>,
    place: usize,
    line: usize,
}

impl Cutter {
    fn peek(&self, ahead: usize) -> Option<char> {
        self.letters.get(self.place + ahead).copied()
    }

    fn step(&mut self) {
        self.line += usize::from(self.peek(0) == Some('\n'));
        self.place += 1;
    }

    fn next_token(&mut self) -> Result<Option<Token>, ImportError> {
        self.skip_blanks_and_comments()?;
        let Some(letter) = self.peek(0) else { return Ok(None) };
        let line = self.line;
        let kind = match letter {
            '0'..='9' => {
                Kind::Number(self.take_while(|letter| letter.is_alphanumeric() || "_'".contains(letter)))
            }
            '"' => Kind::Text(self.text()?),
            _ if is_of_word(letter) => Kind::Word(self.take_while(is_of_word)),
            _ => {
                self.step();
                Kind::Sign(letter)
            }
        };
        Ok(Some(Token { kind, line }))
    }

    fn take_while(&mut self, belongs: impl Fn(char) -> bool) -> String {
        let rest = self.letters[self.place..].iter().copied();
        let taken: String = rest.take_while(|&letter| belongs(letter)).collect();
        self.place += taken.chars().count();
        taken
    }

    fn skip_blanks_and_comments(&mut self) -> Result<(), ImportError> {
        while let Some(letter) = self.peek(0) {
            match (letter, self.peek(1)) {
                ('/', Some('/')) => self.skip_line(),
                ('/', Some('*')) => self.skip_comment()?,
                _ if letter.is_whitespace() || letter == '\u{feff}' => self.step(),
                _ => break,
            }
        }
        Ok(())
    }

    fn skip_line(&mut self) {
        while self.peek(0).is_some_and(|letter| letter != '\n') {
            self.step();
        }
    }

    fn skip_comment(&mut self) -> Result<(), ImportError> {
        let first_line = self.line;
        // Its beginning is passed first: in `/*/` the star does not end the comment as well.
        self.place += 2;
        while (self.peek(0), self.peek(1)) != (Some('*'), Some('/')) {
            if self.peek(0).is_none() {
                return Err(Problem::Truncated { what: "a comment" }.at(first_line));
            }
            self.step();
        }
        self.place += 2;
        Ok(())
    }

    fn text(&mut self) -> Result<String, ImportError> {
        self.step();
        let text = self.take_while(|letter| letter != '"' && letter != '\n');
        if self.peek(0) != Some('"') {
            return Err(Problem::Truncated { what: "a text in quotes" }.at(self.line));
        }
        self.step();
        Ok(text)
    }
}

fn is_of_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> Result<Vec<u64>, ImportError> {
        let numbers = Tokens::of(text)?.list(0, "the list")?;
        Ok(numbers.into_iter().map(|listed| listed.value).collect())
    }

    #[test]
    fn numbers_are_read_in_all_their_spellings() {
        let spellings =
            "{ 0x1fUL, 0X1fL, 31, 31ull , UINT64_C(0x1F),\n(uint64_t) 31,0b1_1111, /* 7, */ 31, // 8,\n}";
        assert_eq!(list(spellings), Ok(vec![31; 8]));
        assert_eq!(list("{0xffffffffffffffffULL}"), Ok(vec![u64::MAX]));
        assert_eq!(list("{}"), Ok(vec![]));
    }

    #[test]
    fn what_is_no_list_of_numbers_is_refused_at_its_line() {
        let refused = |text: &str| list(text).unwrap_err();
        let wanted = "a whole number of up to 64 bits";
        for text in ["0x10000000000000000", "0x", "0xg", "12z"] {
            let problem = Problem::Number { text: text.to_owned(), wanted };
            assert_eq!(refused(&format!("{{1,\n{text}}}")), problem.at(2));
        }
        assert_eq!(refused("{1,\n2,\n3\n"), Problem::Truncated { what: "the list" }.at(4));
        assert_eq!(refused("{1\n2}"), Problem::Unexpected { found: "2".to_owned(), wanted: "a comma" }.at(2));
        assert_eq!(
            refused("{1,\"2\"}"),
            Problem::Unexpected { found: "2".to_owned(), wanted: "a number" }.at(1)
        );
        assert_eq!(
            refused("{1,two}"),
            Problem::Unexpected { found: "two".to_owned(), wanted: "a number" }.at(1)
        );
        assert_eq!(refused("{1;}"), Problem::Unexpected { found: ";".to_owned(), wanted: "a number" }.at(1));
        assert_eq!(refused("{1,\n/* 2}\n"), Problem::Truncated { what: "a comment" }.at(2));
        assert_eq!(refused("{1,\n\"2}\n"), Problem::Truncated { what: "a text in quotes" }.at(2));
    }

    #[test]
    fn lines_are_counted_through_comments_and_texts() {
        let tokens = Tokens::of("/*/ a\n\n*/ one // two\n\"/*\" three").unwrap();
        let lines: Vec<usize> = tokens.all.iter().map(|token| token.line).collect();
        assert_eq!((tokens.all.len(), lines), (3, vec![3, 4, 4]));
    }
}
