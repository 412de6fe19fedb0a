//! From the rows of a manifest to jobs: everything is checked before anything starts.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use bsdfkit::{Error, Result};
use bsdfkit_catalog::Record;
use rayon::prelude::*;

use super::job::{Input, Job, Word};
use super::manifest::{Field, Manifest, Row, Value};
use super::name::expect_name;
use super::options::{self, FitOption, Shape};
use super::output::Output;
use super::pattern::found;

/// Keys of a record, as a manifest names them, and as a record does.
const RECORD: [(&str, &str); 10] = [
    ("title", "name"),
    ("maker", "maker"),
    ("manufacturer", "maker"),
    ("class", "class"),
    ("instrument", "instrument"),
    ("date", "date"),
    ("licence", "licence"),
    ("license", "licence"),
    ("doi", "doi"),
    ("notes", "notes"),
];

/// The jobs that `manifest`, read from `path`, asks for, in its order; the contents of all inputs are hashed, at the speed of reading.
///
/// Errors: everything that is wrong, each with line, material, key, expected and found.
pub(crate) fn jobs(path: &Path, manifest: &Manifest) -> std::result::Result<Vec<Job>, Vec<Error>> {
    let beside = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let place = |e: Error| e.context(path.display());
    let folder = std::path::absolute(beside).map_err(|e| vec![Error::io(beside.display(), &e)])?;
    let options = options::all();
    let mut faults: Vec<Error> = unknown(&manifest.usual, &options, &["name", "measurements"]);
    let mut lines: HashMap<String, usize> = HashMap::new();
    let mut orders = Vec::new();
    for row in &manifest.rows {
        let order = Order::of(row, &manifest.usual, &options, &folder, &mut faults);
        let Some(order) = order else { continue };
        // Some file systems know no capitals.
        if let Some(first) = lines.insert(order.name.to_lowercase(), row.line) {
            let text = format!(
                "line {}: name: expected a name of its own, found {:?}, as on line {first}",
                row.line, order.name
            );
            faults.push(Error::format(text));
        }
        orders.push((row.line, order));
    }
    if faults.is_empty() {
        let jobs = orders.into_par_iter().map(|(line, order)| {
            let name = order.name.clone();
            order.job().map_err(|e| place(e.context(format!("line {line}: {name}"))))
        });
        let (good, bad): (Vec<_>, Vec<_>) =
            jobs.collect::<Vec<_>>().into_iter().partition(Result::is_ok);
        faults = bad.into_iter().filter_map(Result::err).collect();
        if faults.is_empty() {
            return Ok(good.into_iter().filter_map(Result::ok).collect());
        }
        return Err(faults);
    }
    Err(faults.into_iter().map(place).collect())
}

/// Keys that say nothing here.
fn unknown(fields: &[Field], options: &[FitOption], but: &[&str]) -> Vec<Error> {
    let mut known = vec!["name", "measurements", "outputs"];
    known.extend(RECORD.map(|r| r.0).iter().filter(|k| !["manufacturer", "license"].contains(k)));
    known.extend(options.iter().map(|o| &*o.key));
    known.retain(|k| !but.contains(k));
    let wrong = |field: &&Field| {
        let key = normal(&field.key);
        let alias = !but.contains(&&*key) && RECORD.iter().any(|r| r.0 == key);
        !alias && !known.contains(&&*key)
    };
    let fault = |field: &Field| {
        let (line, names) = (field.line, known.join(", "));
        Error::format(format!("line {line}: expected a key of {names}, found {:?}", field.key))
    };
    fields.iter().filter(wrong).map(fault).collect()
}

/// Keys with hyphens are those with _.
fn normal(key: &str) -> String {
    key.trim().replace('-', "_").to_ascii_lowercase()
}

/// What a row asks for, every key understood; nothing read yet.
struct Order {
    name: String,
    measurements: Vec<PathBuf>,
    outputs: Vec<Output>,
    record: Record,
    /// Options of fit, those that name files with their path.
    options: Vec<(String, Option<PathBuf>)>,
}

impl Order {
    /// What `row` says, and where it is silent `usual`; what is wrong goes to `faults`.
    fn of(
        row: &Row,
        usual: &[Field],
        options: &[FitOption],
        folder: &Path,
        faults: &mut Vec<Error>,
    ) -> Option<Self> {
        let before = faults.len();
        faults.extend(unknown(&row.fields, options, &[]));
        let mut said: HashMap<String, &Field> = HashMap::new();
        for field in usual {
            said.insert(normal(&field.key), field);
        }
        let mut own: HashMap<String, usize> = HashMap::new();
        for field in &row.fields {
            let key = normal(&field.key);
            if own.insert(key.clone(), field.line).is_some() {
                let text = format!("line {}: {key}: expected it once, found it twice", field.line);
                faults.push(Error::format(text));
            }
            said.insert(key, field);
        }
        let name = match said.get("name").map(|f| (&f.value, f.line)) {
            Some((Value::One(name), line)) => match expect_name(name) {
                Ok(()) => name.clone(),
                Err(e) => {
                    faults.push(e.context(format!("line {line}: name")));
                    return None;
                }
            },
            _ => {
                let text = format!("line {}: name: expected a text, found none", row.line);
                faults.push(Error::format(text));
                return None;
            }
        };
        let mut order = Self {
            name: name.clone(),
            measurements: Vec::new(),
            outputs: Output::USUAL.to_vec(),
            record: Record::default(),
            options: Vec::new(),
        };
        let mut complain = |line: usize, key: &str, e: Error| {
            faults.push(e.context(format!("line {line}: {name}: {key}")));
        };
        match said.get("measurements") {
            None => complain(
                row.line,
                "measurements",
                Error::format("expected files or folders, found none"),
            ),
            Some(field) => {
                for text in texts(&field.value) {
                    match found(folder, text) {
                        Ok(paths) => order.measurements.extend(paths),
                        Err(e) => complain(field.line, "measurements", e),
                    }
                }
            }
        }
        if let Some(field) = said.get("outputs") {
            let outputs: Result<Vec<Output>> =
                texts(&field.value).iter().map(|text| text.trim().parse()).collect();
            match outputs.and_then(expect_distinct) {
                Ok(outputs) => order.outputs = outputs,
                Err(e) => complain(field.line, "outputs", e),
            }
        }
        match record(&name, &said) {
            Ok(record) => order.record = record,
            Err((line, e)) => complain(line, "record", e),
        }
        for option in options {
            let Some(field) = said.get(&option.key) else { continue };
            match order.option(option, &field.value, folder) {
                Ok(()) => {}
                Err(e) => complain(field.line, &option.key, e),
            }
        }
        if let Err(e) = options::expect_taken(&order.words()) {
            // Of each alone it was said already.
            if faults.len() == before {
                faults.push(e.context(format!("line {}: {name}", row.line)));
            }
        }
        (faults.len() == before).then_some(order)
    }

    /// Takes one option of fit.
    fn option(&mut self, option: &FitOption, value: &Value, folder: &Path) -> Result<()> {
        let long = &option.long;
        match (option.shape, value) {
            (Shape::Flag, Value::One(text)) if text == "true" => {
                self.options.push((long.clone(), None));
            }
            (Shape::Flag, Value::One(text)) if text == "false" => {}
            (Shape::Flag, _) => {
                let found = texts(value).join(", ");
                return Err(Error::format(format!("expected true or false, found {found:?}")));
            }
            (Shape::File, Value::One(text)) => {
                let [path] = &found(folder, text)?[..] else {
                    return Err(Error::format(format!("expected one file, found {text:?}")));
                };
                self.options.push((long.clone(), Some(path.clone())));
            }
            (Shape::Many, _) => {
                for text in texts(value) {
                    self.options.push((format!("{long}={text}"), None));
                }
            }
            (Shape::One, Value::One(text)) => {
                let word = format!("{long}={text}");
                options::expect_taken(std::slice::from_ref(&word))?;
                self.options.push((word, None));
            }
            (Shape::One | Shape::File, Value::Many(all)) => {
                let text = format!("expected one value, found {}", all.len());
                return Err(Error::format(text));
            }
        }
        Ok(())
    }

    /// The options as words.
    fn words(&self) -> Vec<String> {
        let file = |path: &PathBuf| path.display().to_string();
        let words = self.options.iter().map(|(word, path)| match path {
            Some(path) => format!("{word}={}", file(path)),
            None => word.clone(),
        });
        words.collect()
    }

    /// Reads the inputs.
    fn job(self) -> Result<Job> {
        let mut words = Vec::new();
        let mut inputs = Vec::new();
        for path in self.measurements {
            words.push(Word::Input(inputs.len()));
            inputs.push(Input::of(path)?);
        }
        let names = [("--name", &self.record.name), ("--manufacturer", &self.record.maker)];
        let names = names.iter().filter(|(_, text)| !text.is_empty());
        words.extend(names.map(|(word, text)| Word::Text(format!("{word}={text}"))));
        for (word, path) in self.options {
            words.push(Word::Text(word));
            if let Some(path) = path {
                words.push(Word::Input(inputs.len()));
                inputs.push(Input::of(path)?);
            }
        }
        let mut outputs = Vec::new();
        for output in self.outputs {
            let file = output.file(&self.name);
            words.extend(output.marks().into_iter().map(Word::Text));
            words.extend([Word::Text("-o".into()), Word::Output(file.clone())]);
            outputs.push(file);
        }
        let record: serde_json::Map<_, _> = self
            .record
            .fields()
            .into_iter()
            .filter(|(_, text)| !text.is_empty())
            .map(|(key, text)| (key.to_owned(), text.into()))
            .collect();
        let record = serde_json::to_string_pretty(&record).unwrap_or_default();
        Ok(Job::new(self.name, words, inputs, outputs, record))
    }
}

/// The texts of a value.
fn texts(value: &Value) -> &[String] {
    match value {
        Value::One(text) => std::slice::from_ref(text),
        Value::Many(all) => all,
    }
}

/// What is said of the material, called `name` unless it has a title; errors with their line.
fn record(
    name: &str,
    said: &HashMap<String, &Field>,
) -> std::result::Result<Record, (usize, Error)> {
    let mut object = serde_json::Map::new();
    object.insert("name".into(), name.into());
    let mut line = 0;
    for (key, field) in RECORD {
        let Some(found) = said.get(key) else { continue };
        line = found.line;
        let Value::One(text) = &found.value else {
            return Err((line, Error::format(format!("{key}: expected one text, found several"))));
        };
        object.insert(field.into(), text.clone().into());
    }
    Record::from_json(&serde_json::Value::from(object).to_string()).map_err(|e| (line, e))
}

fn expect_distinct(outputs: Vec<Output>) -> Result<Vec<Output>> {
    if outputs.is_empty() {
        return Err(Error::format("expected at least one, found none"));
    }
    for (k, output) in outputs.iter().enumerate() {
        if outputs[..k].iter().any(|o| o.file("x") == output.file("x")) {
            let text = format!("expected each file once, found {:?} again", output.to_string());
            return Err(Error::format(text));
        }
    }
    Ok(outputs)
}
