//! Slopes, crownings and twist of the fits of a job's iterations.

use serde_json::{Value, json};

use super::{spur, taken};
use crate::{
    harness::{Answer, TestApp, send},
    shapes::examples,
};

const FIGURES: [&str; 5] =
    ["profile_slope_um", "helix_slope_um", "profile_crowning_um", "helix_crowning_um", "twist_um"];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// Roll lengths, z and µm of material over a flank.
fn grid() -> (Vec<f64>, Vec<f64>, Vec<Vec<f64>>) {
    let profile: Vec<f64> = (0..9).map(|i| 5.0 + 0.7 * f64::from(i)).collect();
    let z: Vec<f64> = (0..7).map(|j| 1.0 + 2.0 * f64::from(j)).collect();
    let height = |p: &f64, z: &f64| {
        let (u, v) = ((p - 7.8) / 2.8, (z - 7.0) / 6.0);
        3.0 * u - 2.0 * v - 1.5 * u * u - 2.5 * v * v + 0.8 * u * v + 0.2 * (17.0 * p + 5.0 * z).sin()
    };
    let rows = profile.iter().map(|p| z.iter().map(|z| height(p, z)).collect()).collect();
    (profile, z, rows)
}

pub fn axes() -> Value {
    json!({"u": {"quantity": "roll_length", "unit": "mm"}, "v": {"quantity": "face_width", "unit": "mm"},
           "z": {"quantity": "deviation", "unit": "um"}})
}

/// An iteration of the right flank, of second order without regularisation.
pub fn iteration() -> Value {
    let (u, v, z) = grid();
    json!({"nodes": {"type": "grid", "u": u, "v": v, "z": z}, "flank": "right", "tooth": "1", "axes": axes(),
           "model": {"type": "polynomial", "degree": 2, "terms": "total"}, "regularization": {"type": "none"}})
}

pub async fn job(app: &TestApp, body: Value) -> String {
    let made = send(app.post("/v1/jobs", body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made.header("location").to_owned()
}

pub async fn posted(app: &TestApp, path: &str, body: &Value) -> Answer {
    let made = send(app.post(path, body.to_string())).await;
    assert_eq!(made.status, 201, "{}", made.text);
    made
}

pub async fn get(app: &TestApp, path: &str) -> Value {
    let found = send(app.get(path)).await;
    assert_eq!(found.status, 200, "{}", found.text);
    found.json()
}

/// Surface of the same deviations, fitted by another way.
async fn surface(app: &TestApp, limits: &Value) -> Value {
    let (profile, z, rows) = grid();
    let request = json!({"gear": spur(), "flank": "right", "profile": profile, "z_mm": z, "deviation_um": rows,
        "tolerance_limits": limits});
    taken(app, "/v1/gears/flank-surface", &request).await
}

#[track_caller]
fn alike(found: &Value, want: &Value) {
    for name in FIGURES {
        let (found, want) = (&found[name], &want[name]);
        for field in ["value", "std_error", "least_squares"] {
            assert!((number(&found[field]) - number(&want[field])).abs() < 1e-6, "{name} {field}: {found} {want}");
        }
        for end in [0, 1] {
            assert!((number(&found["interval"][end]) - number(&want["interval"][end])).abs() < 1e-6, "{name}: {found}");
        }
        assert_eq!((&found["within"], &found["interval_kind"]), (&want["within"], &want["interval_kind"]), "{name}");
        assert_eq!(found["conformity"]["verdict"], want["conformity"]["verdict"], "{name}: {found} {want}");
    }
}

#[tokio::test]
async fn figures_are_by_the_gear_that_the_job_has_when_the_nodes_come() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "flank"})).await;
    let iterations = format!("{job}/iterations");
    let figures = async || posted(&app, &iterations, &iteration()).await.json()["fits"][0]["figures"].clone();
    let change = async |body: Value| {
        let changed = send(app.client.patch(app.url(&job)).json(&body)).await;
        assert_eq!(changed.status, 200, "{}", changed.text);
    };
    let without = figures().await;
    change(json!({"gear": spur()})).await;
    let with = figures().await;
    assert_ne!(with, without);
    assert_eq!(figures().await, with);
    change(json!({"clear": ["gear"]})).await;
    assert_eq!(figures().await, without);
}

#[tokio::test]
async fn fits_have_the_figures_that_their_job_required() {
    let app = TestApp::start().await;
    let limits = json!({"class": 6, "profile_crowning_um": [0.0, 5.0], "right": {"twist_um": [20.0, 30.0]}});
    let job = job(&app, json!({"name": "w", "gear": spur(), "requirements": {"tolerance_limits": limits}})).await;
    let made = posted(&app, &format!("{job}/iterations"), &iteration()).await;
    let figures = made.json()["fits"][0]["figures"].clone();
    let want = surface(&app, &limits).await;
    alike(&figures, &want);
    assert_eq!(figures["warnings"], json!([]));
    assert_eq!(figures["profile_slope_um"]["within"], json!(true));
    assert_eq!(figures["twist_um"]["conformity"]["verdict"], "does_not_conform");
    assert_eq!(
        (&figures["roll_length_range_mm"], &figures["z_range_mm"]),
        (&want["roll_length_range_mm"], &want["z_range_mm"])
    );

    // reported wherever the fit is, in the same words
    let place = format!("{job}/iterations/1");
    let id = made.json()["fits"][0]["id"].as_str().unwrap().to_owned();
    assert_eq!(get(&app, &format!("{place}/fits/{id}")).await["figures"], figures);
    assert_eq!(get(&app, &place).await["fits"][0]["figures"], figures);
    assert_eq!(get(&app, &format!("{place}/fits")).await["items"][0]["figures"], figures);
    assert_eq!(get(&app, &format!("{job}/trace")).await["iterations"][0]["fits"][0]["figures"], figures);
    assert_eq!(get(&app, &format!("{job}/iterations")).await["items"][0]["chosen_fit"]["figures"], figures);

    // a requirement that is changed later leaves them; another fit is compared with it
    let other = json!({"profile_slope_um": [-1.0, 1.0]});
    let patch = json!({"requirements": {"tolerance_limits": other}});
    assert_eq!(send(app.client.patch(app.url(&job)).json(&patch)).await.status, 200);
    assert_eq!(get(&app, &format!("{place}/fits/{id}")).await["figures"], figures);
    let refit = json!({"model": {"type": "polynomial", "degree": 2, "terms": "total", "basis": "chebyshev"},
        "regularization": {"type": "none"}});
    let later = posted(&app, &format!("{place}/fits"), &refit).await.json()["figures"].clone();
    alike(&later, &surface(&app, &other).await);
    assert_eq!(later["profile_slope_um"]["within"], json!(false));
    // and a replay is the fit itself
    let replay = send(app.post(&format!("{place}/fits/{id}/replay"), "{}")).await;
    assert_eq!(replay.json(), json!({"identical": true}));
}

#[tokio::test]
async fn units_and_signs_of_the_axes_make_no_difference() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "w", "gear": spur()})).await;
    let mut body = iteration();
    let base = 26.0 * 20f64.to_radians().cos();
    let (u, v, z) = grid();
    body["nodes"]["u"] = json!(u.iter().map(|roll| (roll / base).to_degrees()).collect::<Vec<f64>>());
    body["nodes"]["v"] = json!(v.iter().map(|z| 1e3 * z).collect::<Vec<f64>>());
    body["nodes"]["z"] =
        json!(z.iter().map(|row| row.iter().map(|z| -1e-3 * z).collect::<Vec<f64>>()).collect::<Vec<_>>());
    body["axes"] = json!({"u": {"quantity": "roll_length", "unit": "deg"}, "v": {"quantity": "face_width", "unit": "um"},
        "z": {"quantity": "deviation", "unit": "mm", "positive": "material_in"}});
    let made = posted(&app, &format!("{job}/iterations"), &body).await.json();
    alike(&made["fits"][0]["figures"], &surface(&app, &json!({})).await);
}

/// Figures count along the normal unless the requirements ask for the transverse plane, where they
/// are greater by 1/cos β_b: a limit between the two is exceeded only there. With tolerances of a
/// class the decision is the same in both.
#[tokio::test]
async fn figures_of_helical_gears_count_along_the_normal_or_transversely() {
    let app = TestApp::start().await;
    let mut gear = spur();
    gear["helix_angle_deg"] = json!(30.0);
    gear["hand"] = json!("right");
    // sin β_b = sin β cos α_n
    let scale = 1.0 / (30f64.to_radians().sin() * 20f64.to_radians().cos()).asin().cos();
    gear.as_object_mut().unwrap().remove("tip_diameter_mm");
    gear.as_object_mut().unwrap().remove("root_diameter_mm");
    let (profile, z, rows) = grid();
    // on the flank of this gear, whose roll lengths are greater
    let profile: Vec<f64> = profile.iter().map(|roll| roll + 3.4).collect();
    let surface = async |direction: Option<&str>| {
        let mut request = json!({"gear": gear, "flank": "right", "profile": profile, "z_mm": z, "deviation_um": rows});
        if let Some(direction) = direction {
            request["direction"] = json!(direction);
        }
        taken(&app, "/v1/gears/flank-surface", &request).await
    };
    let (given, normal) = (surface(None).await, surface(Some("normal")).await);
    let transverse = surface(Some("transverse")).await;
    let slope = number(&given["profile_slope_um"]["value"]);
    assert!(slope > 5.0, "{given}");
    assert_eq!((&given["direction"], &transverse["direction"]), (&json!("normal"), &json!("transverse")));
    for name in FIGURES {
        // figures of given deviations count in the direction in which the deviations were measured
        assert_eq!(given[name]["value"], normal[name]["value"]);
        assert_eq!(given[name]["value"], transverse[name]["value"]);
    }
    let most = 0.5 * (1.0 + scale) * slope;
    let figures = async |direction: Option<&str>, limits: Value| {
        let mut requirements = json!({"tolerance_limits": limits});
        if let Some(direction) = direction {
            requirements["direction"] = json!(direction);
        }
        let job = job(&app, json!({"name": "w", "gear": gear, "requirements": requirements})).await;
        let mut body = iteration();
        body["nodes"]["u"] = json!(profile);
        posted(&app, &format!("{job}/iterations"), &body).await.json()["fits"][0]["figures"].clone()
    };
    let limits = json!({"profile_slope_um": [-most, most]});
    let (along, across) = (figures(None, limits.clone()).await, figures(Some("transverse"), limits).await);
    for name in FIGURES {
        let [along, across, want] = [&along, &across, &normal].map(|found| number(&found[name]["value"]));
        assert!((along - want).abs() < 1e-6 && (across - scale * want).abs() < 1e-6, "{name}: {along} {across} {want}");
    }
    assert_eq!((&along["direction"], &across["direction"]), (&json!("normal"), &json!("transverse")));
    assert_eq!(
        (&along["profile_slope_um"]["within"], &across["profile_slope_um"]["within"]),
        (&json!(true), &json!(false))
    );
    let [along, across] =
        [figures(None, json!({"class": 6})).await, figures(Some("transverse"), json!({"class": 6})).await];
    for name in ["profile_slope_um", "helix_slope_um"] {
        let most = |of: &Value| number(&of[name]["conformity"]["limits_um"][1]);
        assert!((most(&across) - scale * most(&along)).abs() < 1e-9, "{along} {across}");
        assert_eq!(along[name]["conformity"]["verdict"], across[name]["conformity"]["verdict"]);
    }
}

/// The nodes cover 12 of 15 mm of the face width: the slope is extended to all of it and compared
/// with the full limits, or is over the nodes and has their share of the limits.
#[tokio::test]
async fn slopes_refer_to_the_face_width_or_the_evaluated_range() {
    let app = TestApp::start().await;
    let limits = json!({"helix_slope_um": [-10.0, 20.0], "profile_slope_um": [-30.0, 30.0]});
    let figures = async |reference: &str| {
        let requirements = json!({"tolerance_limits": limits, "reference": reference});
        let job = job(&app, json!({"name": "w", "gear": spur(), "requirements": requirements})).await;
        posted(&app, &format!("{job}/iterations"), &iteration()).await.json()["fits"][0]["figures"].clone()
    };
    let (whole, evaluated) = (figures("reference_length").await, figures("evaluated").await);
    let held = |found: &Value, name: &str| found[name]["conformity"]["limits_um"].clone();
    for found in [&whole, &surface(&app, &limits).await] {
        assert_eq!(held(found, "helix_slope_um"), json!([-10.0, 20.0]));
        assert_eq!(held(found, "profile_slope_um"), json!([-30.0, 30.0]));
        assert_eq!(found["helix_reference_length_mm"], json!(15.0));
        assert_eq!(found["z_range_mm"], json!([1.0, 13.0]));
    }
    assert_eq!(held(&evaluated, "helix_slope_um"), json!([-8.0, 16.0]));
    assert_eq!(evaluated["helix_reference_length_mm"], json!(12.0));
    for field in ["value", "std_error"] {
        let [whole, evaluated] = [&whole, &evaluated].map(|found| number(&found["helix_slope_um"][field]));
        assert!((whole - 1.25 * evaluated).abs() < 1e-9, "{whole} {evaluated}");
    }
    for name in ["profile_crowning_um", "helix_crowning_um", "twist_um"] {
        assert_eq!(whole[name], evaluated[name]);
    }
}

/// The standard covers face widths from 4 mm.
#[tokio::test]
async fn a_class_that_bounds_nothing_is_ignored_with_a_warning() {
    let app = TestApp::start().await;
    let mut gear = spur();
    gear["face_width_mm"] = json!(3.5);
    let requirements = json!({"tolerance_limits": {"class": 5, "profile_crowning_um": [0.0, 5.0]}});
    let job = job(&app, json!({"name": "w", "gear": gear, "requirements": requirements})).await;
    let mut body = iteration();
    let z: Vec<f64> = grid().1.iter().map(|z| 0.25 * z).collect();
    body["nodes"]["v"] = json!(z);
    let figures = posted(&app, &format!("{job}/iterations"), &body).await.json()["fits"][0]["figures"].clone();
    assert_eq!(figures["warnings"].as_array().map(Vec::len), Some(1), "{figures}");
    assert_eq!(figures["warnings"][0]["code"], "requirement_left_aside", "{figures}");
    assert!(figures["warnings"][0]["message"].as_str().unwrap().contains("face_width_mm = 3.5"), "{figures}");
    assert_eq!((figures["profile_slope_um"].get("within"), figures["helix_slope_um"].get("within")), (None, None));
    assert_eq!(figures["profile_crowning_um"]["within"], json!(true));
}

#[tokio::test]
async fn what_undecidable_is_left_out_and_it_is_said_why() {
    let app = TestApp::start().await;
    let with_gear = job(&app, json!({"name": "w", "gear": spur()})).await;
    let without = job(&app, json!({"name": "w"})).await;
    let case = async |job: &str, change: &dyn Fn(&mut Value)| {
        let mut body = iteration();
        change(&mut body);
        posted(&app, &format!("{job}/iterations"), &body).await.json()["fits"][0].get("figures").cloned()
    };
    let why = |figures: Option<Value>| {
        let figures = figures.unwrap();
        assert!(FIGURES.iter().all(|name| figures.get(*name).is_none()), "{figures}");
        figures["warnings"][0]["code"].as_str().unwrap().to_owned()
    };
    assert_eq!(why(case(&without, &|_| {}).await), "gear_missing");
    assert_eq!(why(case(&with_gear, &|body| body["model"]["degree"] = json!(1)).await), "not_second_order");
    let spline = |body: &mut Value| body["model"] = json!({"type": "b_spline", "degree": 2, "spans": [3, 2]});
    assert_eq!(why(case(&with_gear, &spline).await), "not_second_order");
    let own = |body: &mut Value| body["axes"]["z"]["trace_lengths"] = json!([30, 33]);
    assert_eq!(why(case(&with_gear, &own).await), "traces_with_own_zeros");
    let strange = |body: &mut Value| body["axes"]["z"]["unit"] = json!("furlong");
    assert_eq!(why(case(&with_gear, &strange).await), "axes_unknown");
    let below = |body: &mut Value| body["axes"]["u"]["quantity"] = json!("diameter");
    assert_eq!(why(case(&with_gear, &below).await), "no_involute");
    assert_eq!(
        why(case(&with_gear, &|body| drop(body.as_object_mut().unwrap().remove("flank"))).await),
        "flank_missing"
    );
    let silent = |body: &mut Value| drop(body.as_object_mut().unwrap().remove("axes"));
    assert_eq!(why(case(&with_gear, &silent).await), "axes_missing");
    let some = |body: &mut Value| drop(body["axes"].as_object_mut().unwrap().remove("z"));
    assert_eq!(why(case(&with_gear, &some).await), "axes_missing");
    // nodes of a job without a gear are not a flank unless their axes say so
    assert_eq!(case(&without, &silent).await, None);
}

#[tokio::test]
async fn finished_streams_have_figures_too() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "w", "gear": spur()})).await;
    let mut spec = iteration();
    let nodes = spec.as_object_mut().unwrap().remove("nodes").unwrap();
    let stream = posted(&app, &format!("{job}/streams"), &spec).await.header("location").to_owned();
    let block = json!({"sequence": 1, "nodes": nodes});
    assert_eq!(send(app.post(&format!("{stream}/nodes"), block.to_string())).await.status, 200);
    let made = posted(&app, &format!("{stream}/finish"), &json!({})).await.json();
    alike(&made["fits"][0]["figures"], &surface(&app, &json!({})).await);
}

#[tokio::test]
async fn iterations_are_listed_in_pages() {
    let app = TestApp::start().await;
    let job = job(&app, json!({"name": "w", "gear": spur()})).await;
    for k in 0..5 {
        let mut body = iteration();
        body["instrument"] = json!(format!("P{k}"));
        posted(&app, &format!("{job}/iterations"), &body).await;
    }
    let decided = json!({"decision": "remachine", "reason": "slope"});
    assert_eq!(send(app.client.patch(app.url(&format!("{job}/iterations/2"))).json(&decided)).await.status, 200);
    let (mut found, mut path) = (Vec::new(), format!("{job}/iterations?limit=2"));
    loop {
        let page = get(&app, &path).await;
        found.extend(page["items"].as_array().unwrap().clone());
        let Some(cursor) = page["next_cursor"].as_str() else { break };
        path = format!("{job}/iterations?limit=2&cursor={cursor}");
    }
    assert_eq!(found.len(), 5);
    for (k, item) in found.iter().enumerate() {
        assert_eq!((&item["number"], &item["instrument"]), (&json!(k + 1), &json!(format!("P{k}"))));
        assert_eq!((&item["flank"], &item["tooth"], &item["axes"]), (&json!("right"), &json!("1"), &axes()));
        let fit = &get(&app, &format!("{job}/iterations/{}", k + 1)).await["fits"][0];
        assert_eq!(&item["chosen_fit"], fit);
        assert_eq!(item.get("decision"), (k == 1).then_some(&json!("remachine")));
    }
    let missing = send(app.get("/v1/jobs/00000000-0000-7000-8000-000000000000/iterations")).await;
    missing.problem(404, "not_found");
    let odd = send(app.get(&format!("{job}/iterations?limit=0"))).await;
    assert_eq!(odd.pointers(), ["/limit"]);
}

/// The list of jobs has short figures, of the chosen fit of the last iteration, and the class of
/// the last evaluation.
#[tokio::test]
async fn listed_jobs_have_figures_and_class() {
    let app = TestApp::start().await;
    let requirements = json!({"tolerance_limits": {"twist_um": [-50.0, 50.0], "profile_slope_um": [-1.0, 1.0]}});
    let job = job(&app, json!({"name": "w", "gear": spur(), "requirements": requirements})).await;
    let listed = async |query: &str| get(&app, &format!("/v1/jobs{query}")).await["items"].clone();
    assert_eq!((listed("").await[0].get("figures"), listed("").await[0].get("class")), (None, None));
    let figures = posted(&app, &format!("{job}/iterations"), &iteration()).await.json()["fits"][0]["figures"].clone();
    let in_list = listed("").await[0]["figures"].clone();
    for name in FIGURES {
        assert_eq!(in_list[name], figures[name]["value"], "{name}");
    }
    assert_eq!(in_list["within"], json!(false), "the profile slope is beyond its limits");
    assert_eq!(listed("").await[0]["flank"], json!("right"), "whose figures they are");
    let mut evaluation = examples("create_iteration_evaluation")[0].1.clone();
    evaluation["traces"][0]["flank"] = json!("right");
    let kept = posted(&app, &format!("{job}/iterations/1/evaluations"), &evaluation).await.json();
    let class = kept["result"]["class"].as_u64().unwrap();
    assert_eq!(listed("").await[0]["class"], json!(class));
    assert_eq!(listed(&format!("?class={class}")).await.as_array().unwrap().len(), 1);
    assert_eq!(listed(&format!("?class={}", 12 - class)).await.as_array().unwrap().len(), usize::from(class == 6));
    for odd in ["0", "12", "x", "5.5", ""] {
        assert_eq!(send(app.get(&format!("/v1/jobs?class={odd}"))).await.pointers(), ["/class"], "{odd}");
    }
}
