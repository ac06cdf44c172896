//! Direction of counting of teeth: from the request, code 161 or the run-out of the file.

use serde_json::json;

use super::{
    import::{import, job},
    pitch_kept::{file, records, tables},
    spur, taken,
};
use crate::{harness::TestApp, shapes::close};

/// Returns the index deviation of tooth i, µm, of a gear with an eccentricity of 20 µm towards
/// tooth 0, of the left (side 1) or right (−1) flank. Flanks are displaced along their normals, and
/// the space after a tooth is bounded by its left flank if teeth are counted counterclockwise.
fn eccentric(teeth: f64, side: f64, i: u32) -> f64 {
    let at = (f64::from(i) + 0.25 * side) * std::f64::consts::TAU / teeth;
    20.0 * (side * 20f64.to_radians().tan() * at.cos() - at.sin())
}

#[tokio::test]
async fn the_direction_of_counting_decides_the_run_out() {
    let app = TestApp::start().await;
    let flank = |side: f64| (0..17).map(|i| eccentric(17.0, side, i)).collect::<Vec<f64>>();
    let mut request = json!({"gear": {"teeth": 17, "normal_module_mm": 2.0},
        "left": {"index_deviation_um": flank(1.0)}, "right": {"index_deviation_um": flank(-1.0)}});
    for (counting, runout, class) in [("counterclockwise", 39.7, 8), ("clockwise", 6.7, 3)] {
        request["counting"] = json!(counting);
        let found = taken(&app, "/v1/gears/pitch", &request).await;
        close(found["runout"]["runout_um"].as_f64().unwrap(), runout, 0.1);
        assert_eq!((&found["runout"]["class"], &found["counting"]), (&json!(class), &json!(counting)));
    }
    // direction of counting unknown: no run-out, and a warning
    request.as_object_mut().unwrap().remove("counting");
    let found = taken(&app, "/v1/gears/pitch", &request).await;
    assert_eq!((found.get("runout"), found.get("counting")), (None, None));
    assert_eq!(found["warnings"][0]["code"], "no_runout");
    close(found["tooth_thickness_variation_um"].as_f64().unwrap(), 21.4, 0.1);
    app.stop().await;
}

#[tokio::test]
async fn code_161_determines_the_direction_of_tooth_numbers() {
    let app = TestApp::start().await;
    let text = String::from_utf8(file(&[])).unwrap();
    let at = text[..text.find("ZSDEF").unwrap()].rfind('\n').unwrap() + 1;
    for (setting, counting) in [(1, Some("counterclockwise")), (0, Some("clockwise")), (7, None)] {
        let line = format!("  161 :Zaehlrichtung 0-im Uhrzeigersinn     :ZRICH: {setting}\r\n");
        let place = job(&app, Some(spur())).await;
        let content = format!("{}{line}{}", &text[..at], &text[at..]).into_bytes();
        assert_eq!(import(&app, &place, content, "1.mka", None).await.status, 201);
        let kept = records(&app, &place, "pitch").await.1.unwrap();
        assert_eq!(kept["result"]["counting"].as_str(), counting);
        assert_eq!(kept["request"]["counting"].as_str(), counting);
        let warnings = kept["result"]["warnings"].as_array().unwrap();
        assert_eq!(warnings.iter().any(|warning| warning["code"] == "pitch_sign_assumed"), counting.is_none());
    }
    app.stop().await;
}

/// Without code 161 the run-out of the file decides; with code 161 it can contradict the code.
#[tokio::test]
async fn the_run_out_of_a_file_determines_the_direction() {
    let app = TestApp::start().await;
    let [left, right] = [1.0, -1.0].map(|side| move |tooth: u32| eccentric(52.0, side, tooth - 1));
    // a ball in the space after the tooth moves outwards with the gear
    let space = |tooth: u32| 20.0 * ((f64::from(tooth) - 0.5) * std::f64::consts::TAU / 52.0).cos();
    let text = String::from_utf8(tables([&left, &right], &space, &[])).unwrap();
    let at = text[..text.find("ZSDEF").unwrap()].rfind('\n').unwrap() + 1;
    for (line, counting, code) in [
        ("", "counterclockwise", Some("pitch_sign_assumed")),
        ("  161 :Zaehlrichtung :ZRICH: 1\r\n", "counterclockwise", None),
        ("  161 :Zaehlrichtung :ZRICH: 0\r\n", "clockwise", Some("counting_contradicted")),
    ] {
        let place = job(&app, Some(spur())).await;
        let content = format!("{}{line}{}", &text[..at], &text[at..]).into_bytes();
        assert_eq!(import(&app, &place, content, "1.mka", None).await.status, 201);
        let result = records(&app, &place, "pitch").await.1.unwrap()["result"].clone();
        assert_eq!(result["counting"], counting, "{line}");
        let codes: Vec<&str> =
            result["warnings"].as_array().unwrap().iter().filter_map(|warning| warning["code"].as_str()).collect();
        for known in ["pitch_sign_assumed", "counting_contradicted"] {
            assert_eq!(codes.contains(&known), code == Some(known), "{line} {codes:?}");
        }
        if counting == "counterclockwise" {
            close(result["runout"]["runout_um"].as_f64().unwrap(), 40.0, 0.2);
        }
    }
    app.stop().await;
}
