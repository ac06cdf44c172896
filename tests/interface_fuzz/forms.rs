//! Bodies as `multipart/form-data`: a table or a file of an instrument, and a spec.

use super::{
    contract::{Contract, Operation},
    klingelnberg_file::{Gear, Lines, Style, Trace},
    mutate,
    node::Node,
    rexs_file::Model,
    rng::Rng,
};
use serde_json::Value;

const TABLES: [&str; 7] = [
    "x,y\n0,1\n1,3.1\n2,4.9\n3,7.2\n4,9.1\n",
    "u,v,z,weight\n0,0,1,1\n0,1,2,1\n1,0,3,1\n1,1,,1\n1,2,4.5,2\n2,2,5,0.5\n2,0,1,1\n0,2,3,1\n",
    "u,v,z\n0,0,1\n0,1,2\n1,0,3\n1,1,4\n2,0,5\n2,1,6\n",
    "Rollweg [mm];Breite [mm];Abweichung [µm];\r\n5,9;0,5;1,2;\r\n5,9;1,5;-0,3;\r\n6,1;0,5;;\r\n6,1;1,5;2;\r\n",
    "u\\v,0.5,1.5,2.5\n1,0.1,0.2,0.3\n2,0.4,,0.6\n3,0.7,0.8,0.9\n",
    "# points\n[A]\n  1;  3.1; 78.9; 0.0;\n  2;  3.2; 79.4; 2.0;\n",
    "tooth\tflank\troll length\tface width\tdeviation\n1\tleft\t1\t1\t.5\n1\tleft\t2\t1\t.6\n2\tright\t1\t2\t\"1\"\n",
];

const MAPPINGS: [&str; 6] = [
    "{}",
    r#"{"separator": ";", "decimal": ","}"#,
    r#"{"header": true, "matrix": true, "layout": "grid"}"#,
    r#"{"header": false, "matrix": false, "layout": "scattered"}"#,
    r#"{"columns": [{"meaning": "roll_length", "unit": "mm"}, {"meaning": "face_width"}, {"meaning": "deviation", "unit": "um"}]}"#,
    r#"{"separator": "spaces", "columns": [{"meaning": "x"}, {"meaning": "y"}, {"name": "a", "meaning": "ignore"}]}"#,
];

/// Measurements of a gear, as files.
pub struct Files(Vec<(&'static str, Vec<u8>)>);

impl Files {
    pub fn new() -> Self {
        let samples = 24;
        let mut traces = Vec::new();
        for (tooth, index, section) in [("1", 2, 9.4), ("1f", 1, 8.0)] {
            let values = (0..samples).map(|k| Some(0.3 * k as f64)).collect();
            traces.push(Trace { tooth: tooth.into(), left: true, profile: false, index, section, values });
        }
        for (tooth, index, section) in [("1", 2, 7.5), ("1u", 1, 1.0)] {
            let values = (0..samples).map(|k| (k % 9 != 4).then_some(0.2 * k as f64)).collect();
            traces.push(Trace { tooth: tooth.into(), left: true, profile: true, index, section, values });
        }
        let mut curves = Lines::new(&Style::default(), "MK");
        curves.gear(&Gear::spur(), false).traces(&traces);
        let mut model = Model::default();
        let gear = [
            ("number_of_teeth", "none", "31".to_owned()),
            ("normal_module", "mm", "4".to_owned()),
            ("normal_pressure_angle", "deg", "20".to_owned()),
            ("helix_angle", "deg", "22".to_owned()),
            ("face_width", "mm", "30".to_owned()),
        ];
        model.component(1, "cylindrical_gear", "wheel", &gear);
        let points = b"x,y,z\n3.1,78.9,0.0\n3.2,79.4,2.0\n3.3,80.0,4.0\n3.4,80.6,6.0\n".to_vec();
        Files(vec![
            ("1.mka", curves.bytes()),
            ("model.rexs", model.text("1.4").into_bytes()),
            ("points.csv", points),
            ("empty", Vec::new()),
            ("table.txt", TABLES[3].as_bytes().to_vec()),
            ("matrix.dat", TABLES[4].as_bytes().to_vec()),
            ("utf16.csv", TABLES[3].encode_utf16().flat_map(u16::to_le_bytes).collect()),
        ])
    }
}

/// A form for `operation`, its parts those that the contract names. The spec is drawn from the
/// contract, or a JSON body of the operation without its nodes.
pub fn form(
    contract: &Contract,
    operation: &Operation,
    schema: &Value,
    spec: Option<Node>,
    files: &Files,
    rng: &mut Rng,
) -> (String, Vec<u8>) {
    let drawn = contract.value(schema, rng, 0);
    let names: Vec<String> = match &drawn {
        Node::Object(fields) => fields.iter().map(|(name, _)| name.clone()).collect(),
        _ => Vec::new(),
    };
    let mut parts: Vec<(String, String, Vec<u8>)> = Vec::new();
    for name in ["spec", "nodes", "file", "mapping"] {
        let wanted = names.iter().any(|own| own == name) || (name == "file" && operation.bodies.len() == 1);
        if !wanted || rng.percent(3) {
            continue;
        }
        let (head, mut content) = match name {
            "spec" => {
                let spec = spec.clone().or_else(|| drawn.field("spec").cloned()).unwrap_or(Node::Object(Vec::new()));
                (r#"; filename="spec.json""#.to_owned(), spec.written())
            }
            "mapping" => (String::new(), rng.one(MAPPINGS).as_bytes().to_vec()),
            "nodes" => (r#"; filename="nodes.csv""#.to_owned(), rng.one(TABLES).as_bytes().to_vec()),
            _ => {
                let (file, content) = rng.pick(&files.0).cloned().unwrap_or(("none", Vec::new()));
                (format!("; filename=\"{file}\""), content)
            }
        };
        if rng.percent(50) {
            mutate::bytes(&mut content, rng);
        }
        let head = if rng.percent(80) { head } else { String::new() };
        parts.push((name.to_owned(), head, content));
    }
    if rng.percent(5) {
        parts.extend(parts.first().cloned());
    }
    if rng.percent(3) {
        parts.push(("more".to_owned(), String::new(), b"1".to_vec()));
    }
    if rng.percent(10) {
        parts.reverse();
    }
    let boundary = rng.one(["x", "----WebKitFormBoundary7MA4YWxkTrZu0gW", "=_a.b-c"]);
    let mut body = Vec::new();
    for (name, head, content) in parts {
        let media = match rng.below(6) {
            0 => "",
            1 => "content-type: text/plain; charset=utf-8\r\n",
            2 => "content-type: application/octet-stream\r\n",
            _ if name == "spec" || name == "mapping" => "content-type: application/json\r\n",
            _ if name == "nodes" => "Content-Type: text/csv\r\n",
            _ => "",
        };
        body.extend_from_slice(
            format!("--{boundary}\r\nContent-Disposition: form-data; name=\"{name}\"{head}\r\n{media}\r\n").as_bytes(),
        );
        body.extend_from_slice(&content);
        body.extend_from_slice(b"\r\n");
    }
    body.extend_from_slice(format!("--{boundary}--\r\n").as_bytes());
    let quoted = if boundary.contains('=') { format!("\"{boundary}\"") } else { boundary.to_owned() };
    (format!("multipart/form-data; boundary={quoted}"), body)
}
