//! `flankfit openapi`.

use std::io::Write as _;

use clap::Args;

use super::{CommandError, out::out};
use crate::http::openapi::{openapi_3_0_json, openapi_json};

#[derive(Debug, Args)]
pub struct OpenapiArguments {
    /// The copy for generators that read OpenAPI 3.0 only.
    #[arg(long = "v3-0")]
    v3_0: bool,
}

pub fn run(arguments: &OpenapiArguments) -> Result<(), CommandError> {
    let text = if arguments.v3_0 { openapi_3_0_json() } else { openapi_json().to_owned() };
    Ok(out().write_all(text.as_bytes())?)
}
