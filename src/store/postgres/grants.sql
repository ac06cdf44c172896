-- What the service may do where it is not the owner of the tables: members of flankfit_app read everything, add to the trace, and
-- change only what is no part of it. Where there is no such role the owner serves.
DO $$
BEGIN
    -- servers that start together would change the rows of rights at once, which PostgreSQL refuses
    PERFORM pg_advisory_xact_lock(hashtext('flankfit grants'));
    IF EXISTS (SELECT FROM pg_roles WHERE rolname = 'flankfit_app') THEN
        GRANT SELECT ON ALL TABLES IN SCHEMA public TO flankfit_app;
        GRANT INSERT ON audit, audit_chain, audit_seals, jobs, iterations, nodes, fits, fit_choices, decisions, records, streams, stream_blocks,
            stream_states, events, idempotency_keys, probe, api_keys, tenants,
            purges, told, told_until, flanks, table_mappings TO flankfit_app;
        GRANT UPDATE ON jobs, streams, stream_states, idempotency_keys, probe, api_keys, tenants, told_until, flanks,
            table_mappings TO flankfit_app;
        GRANT DELETE ON jobs, streams, stream_blocks, stream_states, events, idempotency_keys, told, told_until, flanks,
            table_mappings TO flankfit_app;
    END IF;
END
$$;
