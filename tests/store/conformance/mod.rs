//! Behaviour of every store, written against the traits alone: a store conforms if it passes all of
//! it. Each case has a new store with two handles, which take turns. (Cases without a server are
//! ignored; `build.rs` looks for one.)

mod all_events;
mod answers;
mod append_only;
mod audit;
mod blocks;
mod extremes;
mod forgery;
mod grounds;
mod job_list;
mod keys;
mod mappings;
mod neighbours;
mod paging;
mod pair;
mod purges;
mod recorder;
mod records;
mod runs;
pub mod streams;
mod teeth;
mod tenants;
mod trace;
mod unaudited;
mod upkeep;
mod writers;

use std::pin::Pin;

/// Cases that run at the same time where one test has all of them.
const AT_A_TIME: usize = 4;

type Case<'a> = Pin<Box<dyn Future<Output = ()> + 'a>>;

/// Makes a test of each case on each store, and one that the cases leave nothing out, which may
/// have another ground of the store.
macro_rules! conformance {
    (stores: $($store:ident and $ground:ident if $there:meta),+; cases: $cases:tt) => {
        $(conformance!(@store $store $ground $there, $cases);)+
    };
    (@store $store:ident $ground:ident $there:meta, { $($group:ident: $($case:ident),+;)+ }) => {
        mod $store {
            use std::sync::Arc;

            use futures_util::stream::{self, StreamExt as _};

            use super::{AT_A_TIME, Case, grounds, pair::Pair, recorder::Exercised};

            $($(
                #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
                #[cfg_attr(not($there), ignore = "there is no server of this kind")]
                async fn $case() {
                    let ground = grounds::$store::$store().await;
                    super::$group::$case(&mut Pair::on(ground, Arc::default()).await).await;
                }
            )+)+

            #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
            #[cfg_attr(not($there), ignore = "there is no server of this kind")]
            async fn every_operation_and_every_refusal_is_met() {
                let exercised = Arc::<Exercised>::default();
                let cases = vec![$($(Box::pin(async {
                    let ground = grounds::$store::$ground().await;
                    super::$group::$case(&mut Pair::on(ground, exercised.clone()).await).await;
                }) as Case<'_>,)+)+];
                stream::iter(cases).buffer_unordered(AT_A_TIME).collect::<Vec<()>>().await;
                assert_eq!(exercised.missed(), Vec::<&str>::new());
            }
        }
    };
}

conformance! {
    stores: sqlite and sqlite if all(), postgres and after_next_version if not(without_postgres);
    cases: {
        answers:
            a_key_stores_once_and_its_answer_outlives_the_store,
            the_first_answer_comes_again_byte_for_byte,
            a_taken_key_stores_nothing,
            a_refused_request_leaves_its_key_free,
            a_claimed_key_is_given_back_with_the_outcome;
        append_only:
            the_trace_is_append_only;
        audit:
            each_change_leaves_one_entry,
            changes_of_keys_and_tenants_are_entered,
            refused_changes_leave_no_entry,
            many_writers_leave_one_chain_without_gaps,
            a_rewritten_chain_contradicts_its_seals,
            one_tenants_damage_keeps_no_other_from_its_seal,
            purged_names_cannot_be_guessed;
        forgery:
            every_column_of_every_table_is_guarded,
            removed_rows_are_detected,
            exchanged_rows_are_detected,
            rows_inserted_by_hand_are_detected,
            one_unreadable_value_hides_nothing,
            a_forged_purge_hides_nothing,
            a_forged_deletion_hides_no_rollback,
            an_older_estimate_is_noticed;
        blocks:
            the_last_estimate_stays_while_blocks_come,
            blocks_are_read_a_few_megabytes_at_a_time,
            a_deleted_stream_leaves_its_iteration;
        extremes:
            nodes_keep_their_bits,
            figures_keep_their_bits_or_are_none,
            texts_of_any_letters_and_length_come_back;
        job_list:
            a_job_is_listed_with_its_state,
            a_changed_measurand_counts_everywhere,
            a_job_has_the_class_of_its_last_evaluation,
            every_new_iteration_opens_its_job,
            jobs_are_found_by_each_filter,
            lists_of_jobs_neither_repeat_nor_skip,
            a_full_last_page_has_no_next,
            jobs_are_counted;
        keys:
            a_key_is_read_as_it_was_stored,
            keys_are_changed_rotated_and_revoked,
            a_replaced_key_is_not_replaced_again,
            ended_keys_stay_ended,
            another_tenants_keys_do_not_exist,
            a_name_of_certificates_is_of_one_key,
            keys_come_in_pages_newest_first,
            tenants_begin_with_a_key,
            keys_are_immutable,
            a_key_is_changed_once_from_each_version;
        mappings:
            a_mapping_is_kept_until_another_takes_its_place,
            mappings_of_a_tenant_are_bounded_and_its_own;
        neighbours:
            neighbours_are_of_the_same_flank_and_tooth,
            rounds_list_iterations_and_corrections;
        paging:
            lists_that_grow_are_read_without_gaps_or_repeats,
            the_order_is_that_of_storing_not_of_ids;
        purges:
            a_purged_job_keeps_its_numbers_and_no_more,
            a_purge_is_done_once,
            a_purge_removes_the_answers_about_its_job_alone,
            a_purge_removes_the_answers_of_its_own_transaction,
            a_purge_comes_before_or_after_each_writer,
            one_of_two_concurrent_purges_is_refused,
            the_trace_loses_only_purged_columns,
            inactive_jobs_are_due;
        records:
            records_come_back_as_they_were_kept_and_page_by_page,
            every_kind_of_record_is_kept,
            a_record_belongs_to_one_iteration,
            an_iteration_comes_with_its_records;
        runs:
            runs_are_stored_atomically;
        streams:
            blocks_are_accepted_in_order_from_concurrent_writers,
            a_job_lets_go_of_its_events_only_with_everything_else,
            a_stream_ends_once,
            streams_are_listed_page_by_page;
        teeth:
            unknown_teeth_are_not_stored,
            results_of_another_gear_are_not_stored,
            an_older_name_of_a_tooth_is_that_tooth,
            a_record_keeps_its_gear;
        tenants:
            another_tenants_reads_find_nothing,
            another_tenants_writes_change_nothing,
            tenants_do_not_meet;
        all_events:
            all_events_are_ordered_and_of_one_tenant,
            concurrent_writes_are_read_exactly_once,
            old_events_leave_the_common_order,
            a_clock_that_was_ahead_keeps_nothing_for_ever;
        trace:
            a_job_comes_back_and_counts_its_changes,
            only_an_empty_job_is_deleted,
            an_iteration_comes_back_bit_for_bit,
            the_trace_keeps_every_choice_and_ruling_in_order,
            actors_are_stored_with_their_changes,
            iterations_are_listed_with_fit_and_decision,
            the_trace_and_the_fits_come_in_pages,
            a_page_of_the_trace_is_bounded_in_bytes_too;
        unaudited:
            changes_without_audit_entry_are_refused;
        upkeep:
            kept_answers_are_forgotten_by_their_age,
            a_store_responds_until_it_is_closed,
            a_full_queue_refuses_only_the_excess;
        writers:
            three_hundred_writers_leave_no_gaps,
            a_write_that_panics_is_refused_alone,
            versions_and_events_count_every_change_once,
            one_request_that_the_store_refuses_does_not_take_others_along,
            a_dropped_request_is_stored,
            a_job_is_changed_once_from_each_version,
            a_job_is_deleted_or_gets_something,
            a_key_is_used_once_by_concurrent_writers;
    }
}
