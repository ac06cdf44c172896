//! Groups of endpoints, each with its handlers and its routes.

pub mod applied;
pub mod audit;
pub mod curves;
pub mod dashboard;
pub mod docs;
pub mod event_pages;
pub mod events;
pub mod fits;
pub mod gear_corrections;
pub mod gear_records;
pub mod gears;
pub mod imports;
pub mod iterations;
pub mod job_fits;
pub mod jobs;
pub mod keys;
pub mod life;
pub mod meta;
pub mod nodes;
pub mod previews;
pub mod records;
pub mod shapes;
pub mod simulations;
pub mod stream_host;
pub mod stream_socket;
pub mod streams;
pub mod studies;
pub mod surfaces;
pub mod tenants;
pub mod trace;

/// Names that most files of endpoints use.
mod prelude {
    pub use axum::{
        Router,
        body::Bytes,
        extract::State,
        http::{HeaderMap, HeaderValue, StatusCode, header},
        response::{IntoResponse, Response},
        routing::get,
    };
    pub use flankfit_engine::estimation::Nodes;
    pub use serde::{Deserialize, Serialize};
    pub use std::{sync::Arc, time::Duration};
    pub use utoipa::{IntoParams, ToSchema};
    pub use utoipa_axum::{router::OpenApiRouter, routes};
    pub use uuid::Uuid;

    pub use super::fits::{json, json_held};
    pub use crate::{
        api::{
            faults::Faults,
            gears::correction::include::StoredIncludeName,
            jobs::{iterations::NewIterationBody, records::RecordBody},
            json::writer::text_of,
            page::PageBody,
            problem::{Problem, ProblemCode, Room},
        },
        http::{
            caller_state::CallerState,
            layers::{
                accept::Format,
                body::Payload,
                compute::{read_json, read_small},
                conditional::{IfMatch, content_tag, etag, set_etag},
                extract::{JsonOf, PathOf, QueryOf},
                files::attachment,
                idempotency::{IdempotencyKey, Post},
                paging::PageQuery,
                unsent::with_permit,
            },
            state::AppState,
        },
        jobs::{Answer, List, RecordKind, RepositoryError, Stored},
        usecases::{budget::WithPermit, nodes},
    };
}
