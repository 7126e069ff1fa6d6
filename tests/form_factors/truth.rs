//! The values that formulas and estimators are held to.

use glam::DVec3;
use serde_json::Value;

/// One known form factor or solution.
pub(crate) struct Truth {
    pub(crate) id: String,
    pub(crate) kind: String,
    params: Value,
    /// The form factor; NaN for a whole solution.
    pub(crate) value: f64,
    pub(crate) values: Value,
}

impl Truth {
    pub(crate) fn number(&self, name: &str) -> f64 {
        self.params[name].as_f64().unwrap()
    }

    pub(crate) fn pair(&self, name: &str) -> [f64; 2] {
        [0, 1].map(|i| self.params[name][i].as_f64().unwrap())
    }

    pub(crate) fn vector(&self, name: &str) -> DVec3 {
        vector(&self.params[name])
    }

    pub(crate) fn polygon(&self, name: &str) -> Option<Vec<DVec3>> {
        Some(self.params[name].as_array()?.iter().map(vector).collect())
    }
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|i| value[i].as_f64().unwrap()))
}

fn read(list: &str) -> Vec<Truth> {
    let file: Value = serde_json::from_str(include_str!("../data/form_factor_truth.json")).unwrap();
    let text = |v: &Value| v.as_str().unwrap().to_owned();
    let truth = |v: &Value| Truth {
        id: text(&v["id"]),
        kind: text(&v["kind"]),
        params: v["params"].clone(),
        value: v["value"].as_f64().unwrap_or(f64::NAN),
        values: v["values"].clone(),
    };
    file[list].as_array().unwrap().iter().map(truth).collect()
}

pub(crate) fn form_factors() -> Vec<Truth> {
    read("form_factors")
}

/// The solutions of a kind.
pub(crate) fn solutions(kind: &str) -> Vec<Truth> {
    let mut found = read("whole_solves");
    found.retain(|t| t.kind == kind);
    assert!(!found.is_empty(), "no solution of the kind {kind}");
    found
}
