//! A file that was changed: what can change while it runs does, and only the rest is started anew.

use super::child::{Child, Upkeep};
use super::live::{self, NotDone};
use super::part::Part;
use super::plan::Plan;
use crate::outcome::complain;

/// Reads the file again and makes the processes what it says; says what it did. A file that cannot be taken changes nothing.
pub(super) fn reload(plan: &mut Plan, children: &mut Vec<Child>) {
    let parts = match plan.read() {
        Ok(parts) => parts,
        Err(failure) => {
            return complain(format_args!(
                "the changed file was not taken, everything goes on as before: {failure}"
            ));
        }
    };
    let mut changes = 0;
    for child in children.iter_mut().filter(|child| is_unwanted(child, &parts)) {
        complain(format_args!("{} is not in the file any more: ending it", child.part.name));
        child.ask_to_end();
        changes += 1;
    }
    for part in parts {
        match children.iter_mut().find(|child| child.part.name == part.name) {
            Some(child) if child.part == part && !child.is_leaving() => continue,
            Some(child) => change(child, part),
            None => {
                complain(format_args!("{} is new in the file: starting it", part.name));
                children.push(Child::new(part, Upkeep::Failures));
            }
        }
        changes += 1;
    }
    if changes == 0 {
        complain("the file was read again and changes nothing");
    }
}

fn is_unwanted(child: &Child, parts: &[Part]) -> bool {
    !child.is_leaving() && parts.iter().all(|part| part.name != child.part.name)
}

fn change(child: &mut Child, part: Part) {
    let name = part.name.clone();
    match live::change(&child.part, &part) {
        Ok(changes) => {
            complain(format_args!("{name} changed while it runs: {}", changes.join("; ")));
            child.part = part;
        }
        Err(NotDone::Refused(reason)) => complain(format_args!("{name} was not changed: {reason}")),
        Err(NotDone::NeedsStart(reason)) => {
            complain(format_args!("{name} is started anew: {reason}"));
            child.become_part(part);
        }
    }
}
