//! One layer over the other.

use std::collections::BTreeMap;
use std::fmt;

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command};
use serde::Serialize;
use serde::de::DeserializeOwned;
use tagbus_family::nearest_name;
use toml::{Table, Value};

use super::file::{File, MACHINE};

/// The flags of a command with the file's values wherever the command line names none.
pub(crate) fn in_force<F>(flags: F, given: &ArgMatches, file: &File) -> Result<F, LayerError>
where
    F: Args + Serialize + DeserializeOwned,
{
    let command = command_of::<F>();
    let mut values = table(&flags)?;
    for (key, value) in &file.keys {
        let arg = command.get_arguments().find(|arg| arg.get_long() == Some(key));
        if key == MACHINE || arg.is_some_and(|arg| !overruled(arg, &command, given)) {
            values.insert(key.clone(), value.clone());
        }
    }
    values.try_into().map_err(|error| LayerError::of_file(file, &error))
}

/// Flags with the values of a table of the file over them. Errors name the table, `place`, and the nearest known key.
pub(crate) fn overlay<F>(flags: &F, keys: &Table, place: &str) -> Result<F, LayerError>
where
    F: Args + Serialize + DeserializeOwned,
{
    let command = command_of::<F>();
    let known: Vec<&str> = command.get_arguments().filter_map(Arg::get_long).collect();
    if let Some(key) = keys.keys().find(|key| !known.contains(&key.as_str())) {
        let nearest = nearest_name(key, &known).unwrap_or_default();
        return Err(LayerError(format!("[{place}]: unknown key \"{key}\", did you mean {nearest}?")));
    }
    let mut values = table(flags)?;
    values.extend(keys.iter().map(|(key, value)| (key.clone(), value.clone())));
    values.try_into().map_err(|error: toml::de::Error| {
        LayerError(format!("[{place}]: {} in {}", error.to_string().trim_end(), keys.to_string().trim_end()))
    })
}

/// Every flag that has a value, as text.
pub(crate) fn values<F: Serialize>(flags: &F) -> Result<BTreeMap<String, String>, LayerError> {
    Ok(table(flags)?.into_iter().map(|(key, value)| (key, plain(&value))).collect())
}

/// The flags as a configuration file.
pub(crate) fn as_toml<F: Serialize>(flags: &F) -> Result<String, LayerError> {
    Ok(table(flags)?.to_string())
}

/// Whether the command line names this flag, or one that excludes it.
fn overruled(arg: &Arg, command: &Command, given: &ArgMatches) -> bool {
    let named = |arg: &Arg| given.value_source(arg.get_id().as_str()) == Some(ValueSource::CommandLine);
    // Clap knows an exclusion only from the side on which it was declared.
    let excludes = |one: &Arg, other: &Arg| {
        command.get_arg_conflicts_with(one).iter().any(|excluded| excluded.get_id() == other.get_id())
    };
    let overrules = |other: &Arg| excludes(arg, other) || excludes(other, arg);
    named(arg) || command.get_arguments().any(|other| named(other) && overrules(other))
}

/// What is in force, as a configuration file.
pub(crate) fn print<F: Serialize>(flags: &F, file: &File) -> Result<String, LayerError> {
    let source = match &file.path {
        Some(path) => format!("# {} is in force below the flags\n", path.display()),
        None => "# no configuration file was found\n".to_owned(),
    };
    Ok(source + &table(flags)?.to_string())
}

/// The command line that puts these flags in force: whatever differs from the defaults.
pub(crate) fn arguments<F: Args + Serialize>(flags: &F) -> Result<Vec<String>, LayerError> {
    let nothing_given = command_of::<F>().get_matches_from([""]);
    let defaults = F::from_arg_matches(&nothing_given).map_err(|error| LayerError::new(&error))?;
    let defaults = table(&defaults)?;
    let differing = table(flags)?.into_iter().filter(|(key, value)| defaults.get(key) != Some(value));
    Ok(differing.map(|(key, value)| format!("--{key}={}", plain(&value))).collect())
}

fn plain(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

fn command_of<F: Args>() -> Command {
    F::augment_args(Command::new("tagbus"))
}

fn table<F: Serialize>(flags: &F) -> Result<Table, LayerError> {
    Table::try_from(flags).map_err(|error| LayerError::new(&error))
}

/// A value in the file that its flag does not take.
#[derive(Debug)]
pub(crate) struct LayerError(String);

impl LayerError {
    fn new(error: &impl fmt::Display) -> Self {
        Self(error.to_string().trim_end().to_owned())
    }

    fn of_file(file: &File, error: &toml::de::Error) -> Self {
        let path = file.path.as_ref().map(|path| format!("{}: ", path.display())).unwrap_or_default();
        Self(format!("{path}{}", error.to_string().trim_end()))
    }
}

impl fmt::Display for LayerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for LayerError {}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::FromArgMatches;

    #[derive(Debug, clap::Args, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "kebab-case")]
    struct Sample {
        #[arg(long, default_value_t = 2.0)]
        decimate: f64,
        #[arg(long)]
        frame_limit: Option<u32>,
        #[arg(long, default_value_t = false, num_args = 0..=1, require_equals = true, default_missing_value = "true")]
        once: bool,
        #[arg(long = "loop", conflicts_with = "once")]
        #[serde(rename = "loop")]
        endless: bool,
    }

    fn merged(arguments: &[&str], file: &str) -> Result<Sample, LayerError> {
        let given = command_of::<Sample>().get_matches_from([&[""], arguments].concat());
        let file = File { path: Some("a.toml".into()), keys: file.parse().unwrap() };
        in_force(Sample::from_arg_matches(&given).unwrap(), &given, &file)
    }

    #[test]
    fn flags_lie_over_the_file_and_the_file_over_defaults() {
        let sample = merged(&["--frame-limit=3"], "frame-limit = 9\ndecimate = 4").unwrap();
        assert_eq!((sample.decimate, sample.frame_limit, sample.once), (4.0, Some(3), false));
        assert!(!merged(&["--once=false"], "once = true").unwrap().once);
        assert_eq!(merged(&["--decimate=2"], "decimate = 4").unwrap().decimate, 2.0);
    }

    #[test]
    fn a_flag_overrules_the_keys_that_it_excludes() {
        let sample = merged(&["--loop"], "once = true").unwrap();
        assert!(sample.endless && !sample.once);
    }

    #[test]
    fn keys_of_other_commands_are_passed_over() {
        assert_eq!(merged(&[], "source = \"scene\"").unwrap().decimate, 2.0);
    }

    #[test]
    fn a_value_of_the_wrong_kind_is_refused_with_file_and_key() {
        let error = merged(&[], "frame-limit = \"many\"").unwrap_err().to_string();
        assert!(error.contains("a.toml") && error.contains("frame-limit"), "{error}");
    }

    #[test]
    fn arguments_put_the_same_in_force() {
        let sample = merged(&["--once", "--frame-limit=3"], "decimate = 1.5").unwrap();
        let arguments = arguments(&sample).unwrap();
        assert_eq!(arguments, ["--decimate=1.5", "--frame-limit=3", "--once=true"]);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        assert_eq!(table(&merged(&arguments, "").unwrap()).unwrap(), table(&sample).unwrap());
    }

    #[test]
    fn what_is_printed_is_a_configuration_file() {
        let text = print(&merged(&["--frame-limit=7"], "").unwrap(), &File::default()).unwrap();
        assert!(text.starts_with("# no configuration file"), "{text}");
        assert_eq!(merged(&[], &text).unwrap().frame_limit, Some(7));
    }
}
