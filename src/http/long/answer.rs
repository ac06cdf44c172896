//! Answers of tasks, as they are kept and as they are given.

use axum::{
    body,
    http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header},
    response::{IntoResponse, Response},
};

use super::super::idempotency::respond;
use crate::{
    api::problem::{Problem, ProblemCode},
    jobs::{TaskAnswer, TaskResult, TaskState, frames},
};

/// Headers of a request that its handler looks at; the key stands beside them.
const OF_REQUEST: [HeaderName; 3] = [header::CONTENT_TYPE, header::CONTENT_ENCODING, header::ACCEPT];

/// Headers of an answer that belong to it, and not to the connection that it is sent over.
const OF_ANSWER: [HeaderName; 4] = [header::CONTENT_TYPE, header::LOCATION, header::ETAG, header::CONTENT_DISPOSITION];

/// How much time compressing takes for how little room.
const LEVEL: i32 = 3;

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

/// Bytes as they are kept. Processor work.
pub fn compressed(bytes: &[u8]) -> Result<Vec<u8>, Problem> {
    zstd::bulk::compress(bytes, LEVEL).map_err(Problem::internal)
}

/// Bytes as they were, no more than so many. Processor work.
pub fn decompressed(bytes: &[u8], most: u64) -> Result<Vec<u8>, Problem> {
    frames::unpacked(bytes, most).map_err(Problem::internal)
}

/// What a handler has answered, read to its end.
pub struct Answered {
    status: StatusCode,
    headers: HeaderMap,
    body: Vec<u8>,
    /// Where it is one.
    pub problem: Option<Problem>,
}

impl Answered {
    /// Reads an answer, which is made as it is read where it is a file.
    pub async fn read(response: Response) -> Self {
        let (parts, body) = response.into_parts();
        let problem = parts.extensions.get::<Problem>().cloned();
        match body::to_bytes(body, usize::MAX).await {
            Ok(body) => Answered { status: parts.status, headers: parts.headers, body: body.into(), problem },
            Err(error) => Problem::internal(error).into(),
        }
    }

    pub fn state(&self) -> TaskState {
        if self.status.is_success() { TaskState::Succeeded } else { TaskState::Failed }
    }

    /// As it is kept, in no more than so many bytes. Processor work.
    pub fn kept(self, most: u64) -> TaskAnswer {
        let refused = |detail: String| Answered::from(Problem::new(ProblemCode::BodyTooLarge, detail)).kept(u64::MAX);
        if self.body.len() as u64 > frames::LONGEST {
            let (length, longest) = (self.body.len(), frames::LONGEST);
            return refused(format!("The answer has {length} bytes, of which {longest} are kept."));
        }
        let body = compressed(&self.body).unwrap_or_default();
        if body.len() as u64 > most {
            return refused(format!("The answer takes {} bytes, of which {most} are kept for a tenant.", body.len()));
        }
        let headers = written(&self.headers, &OF_ANSWER);
        TaskAnswer { status: self.status.as_u16(), headers, body }
    }
}

impl From<Problem> for Answered {
    fn from(problem: Problem) -> Self {
        let status = StatusCode::from_u16(problem.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let body = crate::api::json::writer::text_of(&problem).into_bytes();
        let media = (header::CONTENT_TYPE, HeaderValue::from_static("application/problem+json"));
        Answered { status, headers: HeaderMap::from_iter([media]), body, problem: Some(problem) }
    }
}

/// The problem that a failed task was answered with. Processor work.
pub fn problem(answer: &TaskAnswer) -> Option<Problem> {
    serde_json::from_slice(&decompressed(&answer.body, frames::LONGEST).ok()?).ok()
}

/// The answer that the plain request would have had. Processor work.
pub fn response(result: TaskResult) -> Result<Response, Problem> {
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
    let mut response = (status, decompressed(&answer.body, frames::LONGEST)?).into_response();
    *response.headers_mut() = headers(&answer.headers);
    Ok(response)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let answered = Answered::read(given).await;
        assert_eq!(answered.state(), TaskState::Succeeded);
        let back = response(TaskResult::Own(answered.kept(u64::MAX))).unwrap();
        assert_eq!((back.status(), back.headers()), (StatusCode::CREATED, plain().headers()));
        assert_eq!(body::to_bytes(back.into_body(), 100).await.unwrap(), "{\"number\":1}");
    }

    #[tokio::test]
    async fn a_problem_comes_back_as_one_and_too_much_becomes_one() {
        let refused = || Problem::invalid(crate::api::faults::Faults::one("/nodes", "too few"));
        let answered = Answered::read(refused().into_response()).await;
        assert_eq!((answered.state(), answered.problem.as_ref().map(|p| p.status)), (TaskState::Failed, Some(422)));
        let kept = answered.kept(1 << 20);
        assert_eq!(problem(&kept), Some(refused()));
        let back = response(TaskResult::Own(kept)).unwrap();
        assert_eq!(back.extensions().get::<Problem>(), Some(&refused()));
        let long = Answered::read((StatusCode::OK, "x".repeat(100)).into_response()).await.kept(10);
        assert_eq!((long.status, problem(&long).unwrap().code.as_ref()), (413, "body_too_large"));
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
