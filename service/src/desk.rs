//! Requests to the detector: answered between frames, and never so many that frames would notice.

use std::time::{Duration, Instant};

use tagbus_family::Family;
use tagbus_message::Local;
use tagbus_message::clock::monotonic_ns;
use tagbus_message::control::{
    DetectorAnswer, DetectorAsk, DetectorChange, DetectorReply, DetectorRequest, DetectorStatistics, Outcome,
};
use tagbus_message::control_ports::{Asked, DetectorDesk};
use tagbus_message::qos::MAX_CONTROL_CLIENTS;
use tagbus_message::turns::Turns;
use tagbus_message::wait::{WaitError, Waiter};

use crate::change::{self, Circumstances};
use crate::in_force::InForce;
use crate::report::Summary;
use crate::search::Search;

/// Where requests are answered.
pub(crate) struct Desk<'a> {
    server: &'a DetectorDesk<Local>,
    own_families: Vec<Family>,
    /// Whether somebody called who was perhaps not answered yet.
    called: bool,
    turns: Turns,
    started_ns: u64,
    counts: Counts,
    /// Counts at the last reset, and when that was.
    reset: (Counts, u64),
}

/// What statistics are made of.
#[derive(Clone, Copy, Default)]
struct Counts {
    summary: Summary,
    answered: u64,
    refused: u64,
}

/// What became of a request.
struct Verdict {
    outcome: Outcome,
    text: String,
    /// Whether a detector was built for it, which takes its time.
    was_built: bool,
}

impl Verdict {
    fn done(text: String) -> Self {
        Self { outcome: Outcome::Done, text, was_built: false }
    }

    fn refused(text: String) -> Self {
        Self { outcome: Outcome::Refused, text, was_built: false }
    }
}

impl<'a> Desk<'a> {
    pub(crate) fn new(server: &'a DetectorDesk<Local>, search: &Search) -> Self {
        let started_ns = search.epoch;
        Self {
            server,
            own_families: search.in_force.wish.families.clone(),
            // Somebody may have asked before there was anybody to be woken.
            called: true,
            turns: Turns::new(),
            started_ns,
            counts: Counts::default(),
            reset: (Counts::default(), started_ns),
        }
    }

    /// How long to wait at most, so that a pause ends in time.
    pub(crate) fn patience(&self, longest: Duration) -> Duration {
        match (self.turns.pause(Instant::now()), self.called) {
            (Some(left), _) => left.min(longest),
            (None, true) => Duration::ZERO,
            (None, false) => longest,
        }
    }

    /// Answers those who wait, when it is time to. To be called between frames.
    pub(crate) fn look(&mut self, waiter: &Waiter<Local>, search: &mut Search) -> Result<(), WaitError> {
        self.called |= waiter.take_request();
        let now = Instant::now();
        if !self.turns.may_answer(now) {
            return Ok(());
        }
        waiter.resume_requests()?;
        if self.called {
            self.answer_round(search);
            self.turns.answered(now, Instant::now());
            waiter.pause_requests();
        }
        Ok(())
    }

    /// At most one request of each client, and at most one for which a detector is built.
    fn answer_round(&mut self, search: &mut Search) {
        for _ in 0..MAX_CONTROL_CLIENTS {
            match self.server.next() {
                Ok(Some(asked)) => {
                    if self.answer(asked, search) {
                        return;
                    }
                }
                Ok(None) => {
                    self.called = false;
                    return;
                }
                Err(error) => {
                    self.called = false;
                    return search.trouble(format!("requests cannot be received ({error:?})"));
                }
            }
        }
    }

    /// Says whether a detector was built.
    fn answer(&mut self, asked: Asked<Local, DetectorRequest, DetectorReply>, search: &mut Search) -> bool {
        let verdict = match asked.request().checked() {
            Ok(DetectorAsk::Get) => Verdict::done(String::new()),
            Ok(DetectorAsk::Set(change)) => self.change(&change, search),
            Ok(DetectorAsk::ResetStatistics) => {
                self.counts.summary = search.summary;
                self.reset = (self.counts, monotonic_ns());
                Verdict::done(String::new())
            }
            Err(fault) => Verdict::refused(fault.to_string()),
        };
        self.counts.summary = search.summary;
        self.counts.answered += 1;
        self.counts.refused += u64::from(verdict.outcome == Outcome::Refused);
        asked.answer(&DetectorReply::of(&self.report(search, verdict.outcome, verdict.text)));
        verdict.was_built
    }

    /// The new detector is whole before it takes the place of the old one; one that is not possible changes nothing.
    fn change(&self, change: &DetectorChange, search: &mut Search) -> Verdict {
        let circumstances = Circumstances { own_families: &self.own_families, frame_size: search.frame_size };
        let wish = match change::apply(change, &search.in_force.wish, &circumstances) {
            Ok(wish) => wish,
            Err(reason) => return self.refuse(search, reason),
        };
        let number = search.in_force.control_number() + 1;
        let new = match InForce::new(wish, search.epoch, number) {
            Ok(new) => new,
            Err(error) => return Verdict { was_built: true, ..self.refuse(search, error.to_string()) },
        };
        let what = change::difference(&search.in_force.parameters, &new.parameters);
        let text = change::remarks(&new.wish);
        search.in_force = new;
        search.changed(number, what);
        Verdict { was_built: true, ..Verdict::done(text) }
    }

    fn refuse(&self, search: &mut Search, reason: String) -> Verdict {
        search.trouble(format!("a change was refused: {reason}"));
        Verdict::refused(reason)
    }

    fn report(&self, search: &Search, outcome: Outcome, text: String) -> DetectorAnswer {
        DetectorAnswer {
            outcome,
            text,
            control_number: search.in_force.control_number(),
            state: search.state,
            frame_size: search.frame_size,
            parameters: search.in_force.parameters.clone(),
            statistics: self.statistics(),
        }
    }

    fn statistics(&self) -> DetectorStatistics {
        let (now, (then, since_ns)) = (&self.counts, &self.reset);
        let since = |count: fn(&Summary) -> u64| count(&now.summary) - count(&then.summary);
        DetectorStatistics {
            started_ns: self.started_ns,
            since_ns: *since_ns,
            taken_ns: monotonic_ns(),
            frames_searched: since(|summary| summary.frames_searched),
            frames_skipped: since(|summary| summary.frames_skipped),
            frames_refused: since(|summary| summary.frames_refused),
            tags_found: since(|summary| summary.tags_found),
            messages_sent: since(|summary| summary.messages_sent),
            search_ns: since(|summary| summary.search_ns),
            camera_starts: since(|summary| summary.camera_starts),
            deadlines_missed: since(|summary| summary.deadlines_missed),
            dead_cleaned: since(|summary| summary.dead_cleaned),
            requests_answered: now.answered - then.answered,
            requests_refused: now.refused - then.refused,
        }
    }
}
