-- The trace is append-only, whoever holds the connection.
CREATE FUNCTION refuse_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION '% is append-only', TG_TABLE_NAME USING ERRCODE = 'restrict_violation';
END
$$;

CREATE TRIGGER iterations_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON iterations
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER nodes_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON nodes
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER fits_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON fits
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER fit_choices_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON fit_choices
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER decisions_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON decisions
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER records_append_only BEFORE UPDATE OR DELETE OR TRUNCATE ON records
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();
CREATE TRIGGER events_not_changed BEFORE UPDATE OR TRUNCATE ON events
FOR EACH STATEMENT EXECUTE FUNCTION refuse_change();

-- Only a job that has nothing else takes its events along.
CREATE FUNCTION refuse_loss_of_events() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    IF EXISTS (SELECT FROM iterations WHERE job = OLD.job) OR EXISTS (SELECT FROM streams WHERE job = OLD.job) THEN
        RAISE EXCEPTION 'events is append-only' USING ERRCODE = 'restrict_violation';
    END IF;
    RETURN OLD;
END
$$;
CREATE TRIGGER events_not_lost BEFORE DELETE ON events FOR EACH ROW EXECUTE FUNCTION refuse_loss_of_events();

CREATE FUNCTION refuse_another_tenant() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    RAISE EXCEPTION 'a job stays with its tenant' USING ERRCODE = 'restrict_violation';
END
$$;
CREATE TRIGGER jobs_keep_their_tenant BEFORE UPDATE OF tenant ON jobs FOR EACH ROW
WHEN (NEW.tenant IS DISTINCT FROM OLD.tenant) EXECUTE FUNCTION refuse_another_tenant();

-- The next event of a job. The row of the job is locked by whoever writes, so the next number is free.
CREATE FUNCTION add_event(
    of uuid, kind text, created_at timestamptz, iteration bigint, fit bigint DEFAULT NULL, place bigint DEFAULT NULL
) RETURNS void LANGUAGE sql AS $$
    INSERT INTO events (job, number, kind, created_at, iteration, fit, position)
    SELECT of, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = of), kind, created_at, iteration, fit, place
$$;

CREATE FUNCTION tell_iteration() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'iteration', NEW.created_at, NEW.number);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_iterations AFTER INSERT ON iterations FOR EACH ROW EXECUTE FUNCTION tell_iteration();

-- The first fit belongs to its iteration's event, and so does the first choice.
CREATE FUNCTION tell_fit() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'fit', NEW.created_at, NEW.number, fit => NEW.position);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_fits AFTER INSERT ON fits FOR EACH ROW WHEN (NEW.position > 1) EXECUTE FUNCTION tell_fit();

CREATE FUNCTION tell_choice() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'fit', NEW.created_at, NEW.number, fit => NEW.fit, place => NEW.position);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_choices AFTER INSERT ON fit_choices FOR EACH ROW WHEN (NEW.position > 1)
EXECUTE FUNCTION tell_choice();

CREATE FUNCTION tell_decision() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'decision', NEW.created_at, NEW.number, place => NEW.position);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_decisions AFTER INSERT ON decisions FOR EACH ROW EXECUTE FUNCTION tell_decision();

-- The argument is the state that is told.
CREATE FUNCTION tell_stream() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE told streams := CASE WHEN TG_OP = 'DELETE' THEN OLD ELSE NEW END;
BEGIN
    INSERT INTO events (job, number, kind, created_at, iteration, stream, state, sequence, node_count)
    SELECT told.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = told.job), 'stream', told.updated_at,
           told.iteration, told.id, TG_ARGV[0], told.sequence, told.node_count;
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_new_streams AFTER INSERT ON streams FOR EACH ROW EXECUTE FUNCTION tell_stream('open');
CREATE TRIGGER events_of_blocks AFTER UPDATE OF sequence ON streams FOR EACH ROW WHEN (NEW.sequence > OLD.sequence)
EXECUTE FUNCTION tell_stream('block');
CREATE TRIGGER events_of_finished_streams AFTER UPDATE OF iteration ON streams FOR EACH ROW
WHEN (OLD.iteration IS NULL AND NEW.iteration IS NOT NULL) EXECUTE FUNCTION tell_stream('finished');
-- Whoever deletes a stream first sets its updated_at.
CREATE TRIGGER events_of_deleted_streams AFTER DELETE ON streams FOR EACH ROW EXECUTE FUNCTION tell_stream('deleted');
