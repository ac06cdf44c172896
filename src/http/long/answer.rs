//! Answers of tasks, as they are kept and as they are given.

use axum::{
    http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};

use super::{
    super::{
        budget::{Budget, Permit, WithPermit},
        idempotency::respond,
    },
    packed::{packed, packed_bytes, unpacked},
};
use crate::{
    api::problem::Problem,
    jobs::{TaskAnswer, TaskResult, TaskState, frames},
};

/// Headers of a request that its handler looks at; the key stands beside them.
const OF_REQUEST: [HeaderName; 3] = [header::CONTENT_TYPE, header::CONTENT_ENCODING, header::ACCEPT];

/// Headers of an answer that belong to it, and not to the connection that it is sent over.
const OF_ANSWER: [HeaderName; 4] = [header::CONTENT_TYPE, header::LOCATION, header::ETAG, header::CONTENT_DISPOSITION];

fn written(headers: &HeaderMap, names: &[HeaderName]) -> String {
    let value = |name: &HeaderName| Some((name.as_str().to_owned(), headers.get(name)?.to_str().ok()?.to_owned()));
    serde_json::json!(names.iter().filter_map(value).collect::<Vec<_>>()).to_string()
}

/// Headers of a request, as they are kept.
pub fn of_request(headers: &HeaderMap) -> String {
    written(headers, &OF_REQUEST)
}

/// Headers as they were kept.
pub fn headers(text: &str) -> HeaderMap {
    let pairs: Vec<(String, String)> = serde_json::from_str(text).unwrap_or_default();
    pairs.into_iter().filter_map(|(name, value)| Some((name.parse().ok()?, value.parse().ok()?))).collect()
}

/// What a handler has answered, as it is kept.
pub struct Answered {
    pub answer: TaskAnswer,
    /// Where it is one.
    pub problem: Option<Problem>,
    /// For the bytes of the answer.
    pub permit: Option<Permit>,
}

impl Answered {
    /// Reads an answer, which is made as it is read where it is a file, and packs it into at most
    /// so many bytes.
    pub async fn read(response: Response, budget: &Budget, most: u64) -> Self {
        // with the permit for what it is made of
        let (parts, body) = response.into_parts();
        let body = match packed(body, budget, most).await {
            Ok(body) => body,
            Err(problem) => return problem.into(),
        };
        let (body, permit) = body.into_parts();
        let headers = written(&parts.headers, &OF_ANSWER);
        let answer = TaskAnswer { status: parts.status.as_u16(), headers, body };
        Answered { answer, problem: parts.extensions.get().cloned(), permit: Some(permit) }
    }

    pub fn state(&self) -> TaskState {
        if self.answer.status < 400 { TaskState::Succeeded } else { TaskState::Failed }
    }
}

impl From<Problem> for Answered {
    fn from(problem: Problem) -> Self {
        let media = (header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        let headers = written(&HeaderMap::from_iter([media]), &OF_ANSWER);
        let body = packed_bytes(crate::api::json::writer::text_of(&problem).as_bytes()).unwrap_or_default();
        let answer = TaskAnswer { status: problem.status, headers, body };
        Answered { answer, problem: Some(problem), permit: None }
    }
}

/// The problem that a failed task was answered with. Processor work.
pub fn problem(answer: &TaskAnswer) -> Option<Problem> {
    serde_json::from_slice(&frames::unpacked(&answer.body, frames::LONGEST).ok()?).ok()
}

/// The answer that the plain request would have had, with a permit for it. Processor work.
pub fn response(result: TaskResult, mut permit: Permit) -> Result<Response, Problem> {
    let answer = match result {
        TaskResult::Kept(answer) => return Ok(respond(answer)),
        TaskResult::Own(answer) => answer,
    };
    let status = StatusCode::from_u16(answer.status).map_err(Problem::internal)?;
    if !status.is_success()
        && let Some(problem) = problem(&answer)
    {
        // with the id of the request that asks for it
        return Ok(problem.into_response());
    }
    permit.shrink_to(answer.body.len());
    let mut response = (status, unpacked(WithPermit::new(answer.body, permit))?).into_response();
    *response.headers_mut() = headers(&answer.headers);
    Ok(response)
}

#[cfg(test)]
mod tests {
    use axum::body;

    use super::*;

    async fn read(response: Response) -> Answered {
        Answered::read(response, &Budget::new(1 << 20), u64::MAX).await
    }

    #[tokio::test]
    async fn an_answer_comes_back_with_its_headers_and_bytes() {
        let plain = || {
            let mut response = (StatusCode::CREATED, "{\"number\":1}").into_response();
            for (name, value) in [("location", "/there"), ("etag", "\"1\""), ("content-type", "application/json")] {
                response.headers_mut().insert(name, HeaderValue::from_static(value));
            }
            response
        };
        let mut given = plain();
        given.headers_mut().insert("x-request-id", HeaderValue::from_static("of another"));
        let answered = read(given).await;
        assert_eq!(answered.state(), TaskState::Succeeded);
        let back = response(TaskResult::Own(answered.answer), Budget::new(100).permit()).unwrap();
        assert_eq!((back.status(), back.headers()), (StatusCode::CREATED, plain().headers()));
        assert_eq!(body::to_bytes(back.into_body(), 100).await.unwrap(), "{\"number\":1}");
    }

    #[tokio::test]
    async fn a_problem_comes_back_as_one_and_too_much_becomes_one() {
        let refused = || Problem::invalid(crate::api::faults::Faults::one("/nodes", "too few"));
        for answered in [read(refused().into_response()).await, refused().into()] {
            assert_eq!((answered.state(), answered.problem.as_ref().map(|p| p.status)), (TaskState::Failed, Some(422)));
            assert_eq!(problem(&answered.answer), Some(refused()));
            let back = response(TaskResult::Own(answered.answer), Budget::new(100).permit()).unwrap();
            assert_eq!(back.extensions().get::<Problem>(), Some(&refused()));
        }
        let long = (StatusCode::OK, "x".repeat(100)).into_response();
        let long = Answered::read(long, &Budget::new(1 << 20), 10).await;
        assert_eq!(long.state(), TaskState::Failed);
        assert_eq!((long.answer.status, &*problem(&long.answer).unwrap().code), (413, "answer_too_large"));
    }

    #[test]
    fn a_request_keeps_the_headers_that_matter() {
        let mut given = HeaderMap::new();
        for (name, value) in [("content-type", "text/csv; a=\"é\""), ("accept", "model/step"), ("x-api-key", "secret")]
        {
            given.insert(name, HeaderValue::from_bytes(value.as_bytes()).unwrap());
        }
        let text = of_request(&given);
        assert_eq!(text, r#"[["accept","model/step"]]"#, "and nothing that is no text");
        assert_eq!(headers(&text).len(), 1);
        assert!(headers("damaged").is_empty());
    }
}
