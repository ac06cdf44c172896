//! The scope that each operation of the versioned interface requires. The document has it, and it
//! is enforced (`http/operations.rs`).

use utoipa::openapi::{
    OpenApi as Document,
    extensions::ExtensionsBuilder,
    path::{Operation, PathItem},
};

use crate::jobs::Scope;

/// The member of an operation that names its scope.
pub const REQUIRED_SCOPE: &str = "x-required-scope";

/// Operations that change something, or are no plain GET. An operation not named here is
/// [`Scope::Read`] where it is a GET, and else has no scope, so that it is refused to everybody.
const SCOPES: [(Scope, &str); 6] = [
    (
        Scope::Compute,
        "create_fit study_randomization create_curve evaluate_curve closest_points_of_curve export_curve \
         create_surface evaluate_surface closest_points_of_surface sections_of_surface export_surface \
         gear_geometry gear_flank read_gears read_nodes gear_profile gear_solid_mesh gear_envelope \
         gear_tolerances evaluate_gear gear_pitch gear_deviations gear_flank_surface preview_iteration_fit \
         replay_fit",
    ),
    (
        Scope::Measure,
        "create_job create_iteration import_iteration create_iteration_deviations create_iteration_evaluation \
         create_iteration_pitch create_applied_changes create_gear_applied_changes simulate_closed_loop \
         create_stream add_stream_nodes finish_stream delete_stream connect_stream",
    ),
    (
        Scope::Decide,
        "update_job delete_job create_iteration_fit choose_fit update_iteration create_iteration_curve \
         create_iteration_surface create_iteration_correction create_gear_correction",
    ),
    (Scope::Audit, "list_audit verify_audit list_audit_seals"),
    (Scope::Admin, "create_key list_keys get_key update_key revoke_key rotate_key archive_job purge_job"),
    (Scope::Tenants, "create_tenant list_tenants get_tenant update_tenant"),
];

/// Writes the scope of every operation into the document.
pub fn declare(document: &mut Document) {
    for (path, item) in document.paths.paths.iter_mut().filter(|(path, _)| path.starts_with("/v1/")) {
        let PathItem { get, put, post, delete, patch, .. } = item;
        let reads = get.iter_mut().map(|operation| (operation, Some(Scope::Read)));
        let others = [put, post, delete, patch].into_iter().flatten().map(|operation| (operation, None));
        for (operation, plain) in reads.chain(others) {
            let id = operation.operation_id.as_deref();
            let named = SCOPES.into_iter().find(|(_, ids)| ids.split(' ').any(|named| Some(named) == id));
            match named.map(|(scope, _)| scope).or(plain) {
                Some(scope) => {
                    let scope = ExtensionsBuilder::new().add(REQUIRED_SCOPE, scope.name()).build();
                    operation.extensions.get_or_insert_default().merge(scope);
                }
                None => tracing::error!(path, "an operation has no scope"),
            }
        }
    }
}

/// The scope that the document names.
pub fn of(operation: &Operation) -> Option<Scope> {
    Scope::named(operation.extensions.as_ref()?.get(REQUIRED_SCOPE)?.as_str()?)
}
