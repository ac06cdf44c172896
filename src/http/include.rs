//! The query parameter `include`: what is answered beside the short default, names with commas
//! between them.

use serde::{Deserialize, de::DeserializeOwned};
use serde_json::Value;

use crate::api::{faults::Faults, problem::Problem};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IncludeQuery {
    include: Option<String>,
}

impl IncludeQuery {
    /// The names; one that stands twice counts once, one that there is not is refused.
    pub fn names<T: DeserializeOwned>(&self) -> Result<Vec<T>, Problem> {
        let mut faults = Faults::default();
        let mut names = Vec::new();
        for name in self.include.iter().flat_map(|names| names.split(',')) {
            match serde_json::from_value(Value::from(name)) {
                Ok(name) => names.push(name),
                Err(_) => {
                    let shown: String = name.chars().take(64).collect();
                    faults.push("/include", format!("there is no `{shown}` to include"));
                }
            }
        }
        faults.into_result(names).map_err(Problem::invalid)
    }
}
