//! The gear of a job.

use std::ops::Deref;

use serde::Deserialize;

/// A gear's data as a JSON document, checked on reading the request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JobGear(String);

/// The data of its gear that a job uses.
#[derive(Deserialize)]
struct GearFields {
    teeth: u32,
}

impl JobGear {
    pub fn teeth(&self) -> Option<u32> {
        serde_json::from_str(&self.0).ok().map(|GearFields { teeth }| teeth)
    }
}

impl From<String> for JobGear {
    fn from(document: String) -> Self {
        JobGear(document)
    }
}

impl Deref for JobGear {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_teeth_are_those_of_the_document() {
        let teeth = |document: &str| JobGear::from(document.to_owned()).teeth();
        assert_eq!(teeth(r#"{"teeth":52,"normal_module_mm":1.0,"tool":{"teeth":3}}"#), Some(52));
        assert_eq!(teeth(r#"{"normal_module_mm":1.0}"#), None);
        assert_eq!(teeth("damaged"), None);
    }
}
