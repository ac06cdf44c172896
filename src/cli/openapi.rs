//! `flankfit openapi`.

use std::io::Write;

use clap::Args;

use super::CommandError;
use crate::http::openapi::{openapi_3_0_json, openapi_json};

#[derive(Debug, Args)]
pub struct OpenapiArguments {
    /// The copy for generators that read OpenAPI 3.0 only.
    #[arg(long = "v3-0")]
    v3_0: bool,
}

pub fn run(arguments: &OpenapiArguments) -> Result<(), CommandError> {
    let text = if arguments.v3_0 { openapi_3_0_json() } else { openapi_json() };
    std::io::stdout().write_all(text.as_bytes())?;
    Ok(())
}
