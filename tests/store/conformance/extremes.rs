//! Difficult values come back bit for bit: signed zeros, NaN and infinities, the longest texts and
//! every kind of letter.

use std::{collections::BTreeMap, sync::Arc};

use flankfit::jobs::{
    Choice, Decision, DecisionEvent, Event, Figures, Measurand, MeasurementDetails, NewBlock, NewIteration, NewStream,
    Precondition, Record, nodes_codec,
};
use flankfit_engine::estimation::Nodes;

use super::pair::Pair;
use crate::support::WHOLE;

/// Doubles at the ends of their range. (Of a figure, zero has no sign.)
const DOUBLES: [f64; 7] = [0.0, f64::MIN_POSITIVE, 5e-324, f64::MAX, f64::MIN, f64::EPSILON, 0.1 + 0.2];

/// Letters of one to four bytes, marks that combine, both directions, quotes of SQL and JSON.
const LETTERS: &str =
    "aß漢🦷 e\u{301} \u{200f}שלום\u{200e} '; DROP TABLE jobs; -- \"\\ %_?$1 \u{10ffff}\u{fffd}\u{feff}";

fn bits(nodes: &Nodes) -> Vec<u8> {
    nodes_codec::encode(nodes)
}

pub async fn nodes_keep_their_bits(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    let y = vec![-0.0, 0.0, 5e-324, f64::MIN_POSITIVE, 1e300, -1e300];
    let missing = vec![-0.0, f64::NAN, 5e-324, -f64::NAN, 1e300, -1e300];
    let x = vec![-0.0, 5e-324, 1.0, 2.0, 3.0, 1e15];
    let forms = [
        Nodes::curve(x.clone(), y.clone(), None).unwrap(),
        Nodes::scattered(x.clone(), y.clone(), x.clone(), None).unwrap(),
        Nodes::grid(x[1..4].to_vec(), vec![-1.0, -0.0], missing, None, Some(vec![1.0; 6])).unwrap(),
        Nodes::matrix(x.clone(), 1, y, Some(vec!["µ′ 漢".to_owned()]), None).unwrap(),
    ];
    let stream = Arc::new(place.stream(job));
    store.insert_stream(stream.clone(), None).await.unwrap();
    for (number, nodes) in (1..).zip(forms) {
        let nodes = Arc::new(nodes);
        let iteration = NewIteration { nodes: nodes.clone().into(), ..NewIteration::clone(&place.iteration(job)) };
        store.insert_iteration(Arc::new(iteration), None).await.unwrap();
        let back = store.nodes(job, number).await.unwrap();
        assert_eq!(bits(&back), bits(&nodes));
        let length = bits(&nodes).len();
        assert_eq!(bits(&store.nodes_up_to(job, number, length).await.unwrap().unwrap()), bits(&nodes));
        assert_eq!(store.nodes_up_to(job, number, length - 1).await.unwrap().unwrap_err(), length);
        assert_eq!(store.iteration(job, number).await.unwrap().node_count, 6);
        // the numbers of an estimate are bytes to the store: also what is no number, and infinities
        let numbers = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0, -f64::NAN];
        let state: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let sequence = u64::from(number);
        let block = NewBlock {
            nodes: nodes.clone().into(),
            state: Some(state.clone()),
            ..NewBlock::clone(&place.block(stream.id, sequence))
        };
        store.insert_block(Arc::new(block), None).await.unwrap();
        let (_, stored, _) = store.stream_state(stream.id).await.unwrap();
        assert_eq!(stored.map(|stored| (stored.sequence, stored.data)), Some((sequence, state)));
        assert_eq!(bits(&store.blocks(stream.id, sequence - 1).await.unwrap()[0].nodes), bits(&nodes));
    }
}

pub async fn figures_keep_their_bits_or_are_none(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    let job = place.stored_job(&store).await.id;
    place.stored_iteration(&store, job).await;
    for value in DOUBLES.map(Some).into_iter().chain([None]) {
        let mut fit = place.fit(0.5);
        fit.computed.figures = Figures {
            lambda_star: value,
            criterion: None,
            scheme: None,
            count: Some(u32::MAX),
            condition: value,
            regularized_condition: value,
            bias_norm: value,
            bias_sharp_bound: value,
            rms: value,
            max_abs: value,
        };
        let fit = Arc::new(fit);
        store.insert_fit(job, 1, fit.clone(), None).await.unwrap();
        let listed = store.fits(job, 1, WHOLE).await.unwrap().items.pop().unwrap();
        let back = listed.figures;
        assert_eq!(back, fit.computed.figures);
        for figure in [back.lambda_star, back.condition, back.regularized_condition, back.bias_norm, back.max_abs] {
            assert_eq!(figure.map(f64::to_bits), value.map(f64::to_bits));
        }
        for figure in [back.bias_sharp_bound, back.rms] {
            assert_eq!(figure.map(f64::to_bits), value.map(f64::to_bits));
        }
    }
    for forgetting_factor in [5e-324, f64::EPSILON, 1.0 - f64::EPSILON / 2.0, 1.0] {
        let stream = Arc::new(NewStream { forgetting_factor, ..place.stream(job) });
        store.insert_stream(stream.clone(), None).await.unwrap();
        let back = store.stream(stream.id).await.unwrap().forgetting_factor;
        assert_eq!(back.to_bits(), forgetting_factor.to_bits());
    }
}

pub async fn texts_of_any_letters_and_length_come_back(pair: &mut Pair) {
    let (store, place) = (pair.store.clone(), pair.values.clone());
    for text in [LETTERS.to_owned(), String::new(), " \t\n ".to_owned(), LETTERS.repeat(20_000)] {
        let document: Arc<str> = serde_json::json!({"coefficients": [], "text": text}).to_string().into();
        let some = || Some(text.clone());
        let mut job = place.job(&text);
        (job.part_number, job.serial_number, job.machine) = (some(), some(), some());
        job.gear = Some(document.to_string().into());
        job.requirements = Some(document.clone());
        job.tags = BTreeMap::from([(text.clone(), text.clone())]);
        store.insert_job(job.clone(), None).await.unwrap();
        assert_eq!(store.job(job.id).await.unwrap(), job);

        let new = NewIteration::clone(&place.iteration(job.id));
        let details = MeasurementDetails { instrument: some(), operator: some(), note: some(), ..new.details };
        let measurand = Measurand { tooth: some(), axes: Some(document.clone()), flank: None, accept_units: false };
        let mut fit = new.fit;
        (fit.computed.spec, fit.computed.result) = (document.clone(), document.clone().into());
        (fit.event.reason, fit.event.by) = (some(), some().map(Into::into));
        let new = Arc::new(NewIteration { details, measurand, fit, ..new });
        store.insert_iteration(new.clone(), None).await.unwrap();
        let event = || Event { reason: some(), by: some().map(Into::into), created_at: place.now() };
        let choice = Choice { fit_id: new.fit.id, event: event() };
        store.choose(job.id, 1, choice.clone(), Precondition::None).await.unwrap();
        let decision = DecisionEvent { decision: Decision::Rejected, concession: false, event: event() };
        store.decide(job.id, 1, decision.clone(), Precondition::None).await.unwrap();
        let mut record = Record::clone(&place.record(flankfit::jobs::RecordKind::Evaluation, &text));
        (record.draft.request, record.draft.result) = (document.clone(), document.clone());
        record.draft.gear = Some(document.clone());
        store.insert_record(job.id, 1, Arc::new(record.clone()), None).await.unwrap();

        let back = store.iteration(job.id, 1).await.unwrap();
        assert_eq!((&back.details, &back.measurand), (&new.details, &new.measurand));
        assert_eq!((back.decision, &back.fits[0].event.reason), (Some(decision.clone()), &some()));
        let fit = store.fit(job.id, 1, new.fit.id).await.unwrap();
        assert_eq!((fit.spec, fit.result, fit.event.reason), (document.clone(), document.clone(), some()));
        assert_eq!(store.record(job.id, 1, record.id).await.unwrap(), record);
        let traced = store.trace(job.id, WHOLE).await.unwrap().iterations.remove(0);
        assert_eq!((traced.choices.last(), traced.decisions), (Some(&choice), vec![decision]));
    }
}
