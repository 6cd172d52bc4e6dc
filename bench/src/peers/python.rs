//! Detectors that are reached from Python, in a process of their own (bench/peers/python.py).

use std::cell::RefCell;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::rc::Rc;

use serde_json::{Value, json};
use tagbus_camera::picture::Picture;

use super::{Failure, Hit, Peer};

const PROGRAM: &str = include_str!("../../peers/python.py");

/// The process, shared by all its configurations. Pictures are handed over as a file of raw grey levels.
struct Interpreter {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
    raw: PathBuf,
}

/// One configuration of one detector.
pub(super) struct Python {
    interpreter: Rc<RefCell<Interpreter>>,
    number: usize,
    name: String,
    factor: f64,
    variant: String,
    cpu_us: f64,
}

/// All configurations that this interpreter has for the family.
pub(super) fn all(python: &Path, family: &str) -> Result<Vec<Python>, Failure> {
    let mut interpreter = Interpreter::start(python, family)?;
    let list = interpreter.answer()?;
    let interpreter = Rc::new(RefCell::new(interpreter));
    let configuration = |(number, value): (usize, &Value)| Python {
        interpreter: Rc::clone(&interpreter),
        number,
        name: value["name"].as_str().unwrap_or_default().to_owned(),
        factor: value["factor"].as_f64().unwrap_or(1.0),
        variant: value["variant"].as_str().unwrap_or_default().to_owned(),
        cpu_us: 0.0,
    };
    Ok(list.as_array().into_iter().flatten().enumerate().map(configuration).collect())
}

impl Interpreter {
    fn start(python: &Path, family: &str) -> Result<Self, Failure> {
        let mut child = Command::new(python)
            .args(["-c", PROGRAM, family])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| {
                format!("{} cannot be started ({error}): see bench/peers/python.py", python.display())
            })?;
        let (Some(requests), Some(answers)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("the Python process has no pipes".into());
        };
        let raw = std::env::temp_dir().join(format!("tagbus-bench-{}-{family}.raw", child.id()));
        Ok(Self { child, requests, answers: BufReader::new(answers), raw })
    }

    fn ask(&mut self, request: &Value) -> Result<Value, Failure> {
        writeln!(self.requests, "{request}")?;
        self.answer()
    }

    fn answer(&mut self) -> Result<Value, Failure> {
        let mut line = String::new();
        match self.answers.read_line(&mut line)? {
            0 => Err("the Python process ended: its last words stand above".into()),
            _ => Ok(serde_json::from_str(&line)?),
        }
    }
}

impl Drop for Interpreter {
    fn drop(&mut self) {
        // Nothing is left to be told to anybody if the process or the file is gone already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_file(&self.raw);
    }
}

impl Peer for Python {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn factor(&self) -> f64 {
        self.factor
    }

    fn variant(&self) -> String {
        self.variant.clone()
    }

    fn prepare(&mut self, picture: &Picture) -> Result<(), Failure> {
        // One process serves all configurations, and the first of them brings the picture.
        if self.number > 0 {
            return Ok(());
        }
        let mut interpreter = self.interpreter.borrow_mut();
        std::fs::write(&interpreter.raw, &picture.luma)?;
        let request = json!({ "raw": interpreter.raw, "width": picture.width, "height": picture.height });
        interpreter.ask(&request).map(drop)
    }

    fn detect(&mut self, _picture: &Picture, hits: &mut Vec<Hit>) {
        let request = json!({ "detect": self.number });
        // A process that has ended says so when it is given the next picture.
        let Ok(answer) = self.interpreter.borrow_mut().ask(&request) else { return };
        self.cpu_us = answer["cpu_us"].as_f64().unwrap_or(0.0);
        hits.extend(answer["hits"].as_array().into_iter().flatten().filter_map(hit));
    }

    fn own_cpu_us(&self) -> Option<f64> {
        Some(self.cpu_us)
    }
}

fn hit(value: &Value) -> Option<Hit> {
    let id = u32::try_from(value["id"].as_u64()?).ok()?;
    let corners = serde_json::from_value(value["corners"].clone()).ok()?;
    Some(Hit { id, corners })
}
