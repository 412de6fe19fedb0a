//! The few figures of a material that a summary has, from all that its fit said.

use serde_json::Value;

use super::super::state::{State, Status};

/// What is known of a finished job; of a failed one its time alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Figures {
    pub(super) components: Vec<String>,
    pub(super) incidences: Option<u64>,
    pub(super) points: Option<u64>,
    pub(super) lobes: Option<u64>,
    /// At the incidences, the largest of the components'.
    pub(super) fit_error: Option<f64>,
    /// Between them, likewise; `None` where one is unknown.
    pub(super) between: Option<f64>,
    /// Largest share of light that goes on, of either side at 0, 30 and 60 degrees.
    pub(super) energy: Option<f64>,
    pub(super) seconds: Option<f64>,
    pub(super) cpu_seconds: Option<f64>,
    pub(super) peak_bytes: Option<f64>,
}

impl Figures {
    pub(super) fn of(state: &State) -> Self {
        let seconds = Some(state.seconds);
        if state.status == Status::Failed {
            return Self { seconds, ..Self::default() };
        }
        let report = &state.report;
        let none = Vec::new();
        let parts = report["components"].as_array().unwrap_or(&none);
        let sum = |key: &str| parts.iter().map(|p| p[key].as_u64()).sum();
        let most = |key: &str| -> Option<f64> {
            let all: Option<Vec<f64>> = parts.iter().map(|p| p[key].as_f64()).collect();
            all?.into_iter().reduce(f64::max)
        };
        let name = |p: &Value| p["component"].as_str().unwrap_or_default().to_owned();
        let totals = ["front", "back"].into_iter().filter_map(|side| {
            let of_side: Vec<&Value> = parts.iter().filter(|p| name(p).starts_with(side)).collect();
            let at = |k: usize| {
                let one = |p: &&Value| p["hemispherical_0_30_60_degrees"][k].as_f64();
                of_side.iter().map(one).sum::<Option<f64>>()
            };
            (!of_side.is_empty()).then(|| (0..3).filter_map(at).reduce(f64::max)).flatten()
        });
        Self {
            components: parts.iter().map(name).collect(),
            incidences: sum("incidences"),
            points: sum("points"),
            lobes: sum("lobes"),
            fit_error: most("fit_error"),
            between: most("expected_error"),
            energy: totals.reduce(f64::max),
            seconds,
            cpu_seconds: report["cpu_seconds"].as_f64(),
            peak_bytes: report["peak_bytes"].as_f64(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn components_are_put_together() {
        let part = |name: &str, error: f64, expected: Option<f64>, totals: [f64; 3]| {
            json!({"component": name, "incidences": 3, "points": 10, "lobes": 2, "fit_error": error,
                   "expected_error": expected, "hemispherical_0_30_60_degrees": totals})
        };
        let state = State {
            key: String::new(),
            status: Status::Done,
            error: String::new(),
            outputs: Vec::new(),
            seconds: 2.0,
            report: json!({"components": [
                part("front reflection", 0.1, Some(0.2), [0.5, 0.5, 0.6]),
                part("front transmission", 0.3, None, [0.3, 0.2, 0.0]),
                part("back reflection", 0.1, Some(0.1), [0.7, 0.7, 0.7]),
            ], "cpu_seconds": 1.5}),
        };
        let f = Figures::of(&state);
        assert_eq!((f.incidences, f.points, f.lobes), (Some(9), Some(30), Some(6)));
        assert_eq!((f.fit_error, f.between, f.energy), (Some(0.3), None, Some(0.8)));
        assert_eq!((f.cpu_seconds, f.peak_bytes), (Some(1.5), None));
        let failed = Figures::of(&State { status: Status::Failed, ..state });
        assert_eq!(failed, Figures { seconds: Some(2.0), ..Figures::default() });
    }
}
