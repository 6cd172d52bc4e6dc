//! What is known on a terminal, twice a second, until a key ends it.

use std::io;
use std::time::{Duration, Instant};

use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use ratatui::style::{Color, Style, Stylize};
use ratatui::text::Line;
use ratatui::widgets::Paragraph;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::stop::Stop;

use super::look::Look;
use super::rows::{self, Kind, Row};
use crate::outcome::{Failure, Outcome};

/// Trouble is looked for so often, and shown at once.
const LOOK: Duration = Duration::from_millis(250);
/// Everything else is shown so often: nobody reads faster.
const REFRESH: Duration = Duration::from_millis(500);
/// How long a key or a signal may go unnoticed.
const KEY: Duration = Duration::from_millis(50);
const NO_COLOURS: &str = "NO_COLOR";

/// Shows it until somebody ends it. The terminal is put back whatever happens.
pub(super) fn show(look: &mut Look, domain: &str, stop: &Stop) -> Result<Outcome, Failure> {
    // It puts the terminal back when there is a panic, too.
    let terminal = ratatui::try_init().map_err(|error| {
        Failure::new(format!("the terminal cannot be used ({error}): try `tagbus top --json`"))
    })?;
    let _terminal_as_it_was = Restore;
    Screen { terminal, rows: Vec::new(), first: 0, drawn: None }.work(look, domain, stop)?;
    Ok(Outcome::Done)
}

struct Restore;

impl Drop for Restore {
    fn drop(&mut self) {
        ratatui::restore();
    }
}

struct Screen {
    terminal: DefaultTerminal,
    rows: Vec<Row>,
    /// The first row that is shown below the title.
    first: usize,
    drawn: Option<Instant>,
}

/// What a key asks for.
enum Wish {
    End,
    Draw,
    Nothing,
}

impl Screen {
    fn work(mut self, look: &mut Look, domain: &str, stop: &Stop) -> io::Result<()> {
        let mut looked = None::<Instant>;
        while !stop.is_triggered() {
            if looked.is_none_or(|looked| looked.elapsed() >= LOOK) {
                looked = Some(Instant::now());
                self.take(rows::of(look.again(), domain, monotonic_ns()))?;
            }
            if event::poll(KEY)? {
                match self.wish(&event::read()?) {
                    Wish::End => return Ok(()),
                    Wish::Draw => self.draw()?,
                    Wish::Nothing => {}
                }
            }
        }
        Ok(())
    }

    fn take(&mut self, rows: Vec<Row>) -> io::Result<()> {
        let columns = usize::from(self.terminal.size()?.width);
        let rows: Vec<Row> = rows.into_iter().flat_map(|row| fitted(row, columns)).collect();
        let is_due = self.drawn.is_none_or(|drawn| drawn.elapsed() >= REFRESH);
        let has_news = troubles(&rows) != troubles(&self.rows);
        self.rows = rows;
        if is_due || has_news { self.draw() } else { Ok(()) }
    }

    fn wish(&mut self, event: &Event) -> Wish {
        let rest = self.rows.len().saturating_sub(2);
        match event {
            Event::Key(key) if is_end(key) => return Wish::End,
            Event::Key(KeyEvent { code, kind: KeyEventKind::Press | KeyEventKind::Repeat, .. }) => match code
            {
                KeyCode::Up => self.first = self.first.saturating_sub(1),
                KeyCode::Down => self.first = (self.first + 1).min(rest),
                KeyCode::PageUp => self.first = self.first.saturating_sub(10),
                KeyCode::PageDown => self.first = (self.first + 10).min(rest),
                KeyCode::Home => self.first = 0,
                _ => return Wish::Nothing,
            },
            Event::Resize(..) => {}
            _ => return Wish::Nothing,
        }
        Wish::Draw
    }

    fn draw(&mut self) -> io::Result<()> {
        let Some((title, rest)) = self.rows.split_first() else { return Ok(()) };
        let shown = &rest[self.first.min(rest.len())..];
        let room = usize::from(self.terminal.size()?.height).saturating_sub(2);
        let hidden = shown.len().saturating_sub(room);
        let mut lines = vec![line(title)];
        lines.extend(shown.iter().take(room).map(line));
        let more = if hidden > 0 || self.first > 0 { "  Up, Down, PgUp, PgDn: move" } else { "" };
        let hidden = if hidden > 0 { format!("  {hidden} more rows below") } else { String::new() };
        lines.resize(room + 1, Line::default());
        lines.push(Line::from(format!("q, Esc: end{more}{hidden}")).dim());
        self.terminal.draw(|frame| frame.render_widget(Paragraph::new(lines), frame.area()))?;
        self.drawn = Some(Instant::now());
        Ok(())
    }
}

fn is_end(key: &KeyEvent) -> bool {
    let is_control_c = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
    is_control_c || matches!(key.code, KeyCode::Char('q') | KeyCode::Esc)
}

/// What is wrong is told to its end, in as many rows as it takes; of everything else the beginning counts.
fn fitted(row: Row, columns: usize) -> Vec<Row> {
    if row.kind != Kind::Trouble {
        return vec![row];
    }
    let mut rows: Vec<String> = Vec::new();
    for word in row.text.split(' ') {
        match rows.last_mut() {
            Some(last) if last.chars().count() + 1 + word.chars().count() <= columns => {
                last.push(' ');
                last.push_str(word);
            }
            Some(_) => rows.push(format!("  {word}")),
            None => rows.push(word.to_owned()),
        }
    }
    rows.into_iter().map(|text| Row { kind: Kind::Trouble, text }).collect()
}

/// How much is wrong; what is said of it has seconds in it, which change all the time.
fn troubles(rows: &[Row]) -> usize {
    rows.iter().filter(|row| row.kind == Kind::Trouble).count()
}

fn line(row: &Row) -> Line<'_> {
    let has_colours = std::env::var_os(NO_COLOURS).is_none_or(|value| value.is_empty());
    let style = match row.kind {
        Kind::Title => Style::new().bold().reversed(),
        Kind::Trouble if has_colours => Style::new().bold().fg(Color::Red),
        Kind::Trouble | Kind::Head => Style::new().bold(),
        Kind::Plain => Style::new(),
    };
    Line::styled(row.text.as_str(), style)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn troubles_are_told_to_their_end() {
        let row = |kind, text: &str| Row { kind, text: text.to_owned() };
        let trouble = row(Kind::Trouble, "! client watch (process 7): stuck, took nothing");
        let told: Vec<String> = fitted(trouble, 28).into_iter().map(|row| row.text).collect();
        assert_eq!(told, ["! client watch (process 7):", "  stuck, took nothing"]);
        assert_eq!(fitted(row(Kind::Plain, "as it is"), 3).len(), 1);
    }
}
