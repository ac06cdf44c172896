//! A writer of REXS models that shares nothing with the reader.

use std::fmt::Write as _;

/// An attribute: id, unit and inner XML.
pub type Attribute = (&'static str, &'static str, String);

#[derive(Clone, Debug, Default)]
pub struct Model {
    pub components: String,
    pub relations: String,
    /// Quotes of attributes.
    pub single_quotes: bool,
    pub namespace: bool,
}

impl Model {
    pub fn component(&mut self, id: u32, kind: &str, name: &str, attributes: &[Attribute]) -> &mut Self {
        let _ = writeln!(self.components, "    <component id=\"{id}\" name=\"{name}\" type=\"{kind}\">");
        for (name, unit, value) in attributes {
            let _ = writeln!(self.components, "      <attribute id=\"{name}\" unit=\"{unit}\">{value}</attribute>");
        }
        self.components.push_str("    </component>\n");
        self
    }

    pub fn flanks(&mut self, gear: u32, left: u32, right: u32) -> &mut Self {
        let _ = writeln!(
            self.relations,
            "    <relation id=\"{gear}\" type=\"flank\">\n      <ref hint=\"cylindrical_gear\" id=\"{gear}\" \
             role=\"gear\"/>\n      \
             <ref id=\"{left}\" role=\"left\"/>\n      <ref id=\"{right}\" role=\"right\"/>\n    </relation>"
        );
        self
    }

    /// Ties a measured trace to its flank.
    pub fn reference(&mut self, flank: u32, trace: u32) -> &mut Self {
        let _ = writeln!(
            self.relations,
            "    <relation id=\"{trace}\" type=\"reference\">\n      <ref id=\"{flank}\" role=\"origin\"/>\n      \
             <ref id=\"{trace}\" role=\"referenced\"/>\n    </relation>"
        );
        self
    }

    pub fn text(&self, version: &str) -> String {
        let prefix = if self.namespace { "r:" } else { "" };
        let space = if self.namespace { " xmlns:r=\"https://schemas.example/rexs\"" } else { "" };
        let mut out =
            String::from("<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"no\" ?>\n<!-- made by a test -->\n");
        let _ = writeln!(
            out,
            "<model{space} applicationId=\"test\" applicationVersion=\"1\" date=\"2026-01-01\" version=\"{version}\">"
        );
        let _ = writeln!(
            out,
            "  <relations>\n{}  </relations>\n  <components>\n{}  </components>",
            self.relations, self.components
        );
        // results of a load case, with the ids of the components again
        out.push_str("  <load_spectrum id=\"1\"><load_case id=\"1\"><component id=\"15\" type=\"cylindrical_gear\">");
        out.push_str(
            "<attribute id=\"number_of_teeth\" \
            unit=\"none\">999</attribute></component></load_case></load_spectrum>\n</model>\n",
        );
        if self.namespace {
            for name in [
                "model",
                "relations",
                "relation",
                "ref",
                "components",
                "component",
                "attribute",
                "array",
                "matrix",
                "load_spectrum",
                "load_case",
            ] {
                for (open, close) in [("<", " "), ("<", ">"), ("</", ">")] {
                    out = out.replace(&format!("{open}{name}{close}"), &format!("{open}{prefix}{name}{close}"));
                }
            }
        }
        if self.single_quotes { out.replace('"', "'") } else { out }
    }
}

pub fn array(values: &[f64]) -> String {
    let mut out = String::from("\n        <array>\n");
    for value in values {
        let _ = writeln!(out, "          <c>{value}</c>");
    }
    out.push_str("        </array>\n      ");
    out
}

pub fn matrix(columns: usize, values: &[f64]) -> String {
    let mut out = String::from("<matrix>");
    for row in values.chunks(columns) {
        out.push_str("<r>");
        for value in row {
            let _ = write!(out, "<c>{value}</c>");
        }
        out.push_str("</r>");
    }
    out.push_str("</matrix>");
    out
}

/// Little-endian doubles in base64.
pub fn coded(values: &[f64]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let mut out = String::from("<array code=\"float64\">");
    for three in bytes.chunks(3) {
        let word = three.iter().enumerate().fold(0u32, |word, (k, byte)| word | u32::from(*byte) << (16 - 8 * k));
        for digit in 0..4 {
            let shown = digit <= three.len();
            out.push(if shown { char::from(DIGITS[(word >> (18 - 6 * digit) & 63) as usize]) } else { '=' });
        }
    }
    out.push_str("</array>");
    out
}
