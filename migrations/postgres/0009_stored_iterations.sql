-- Who stores many iterations notes them in their jobs once, before they are there; only what was not noted so is noted here.
CREATE OR REPLACE FUNCTION note_iteration() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET
        iteration_count = greatest(iteration_count, NEW.number), status = 'open', changed_at = greatest(changed_at, NEW.created_at)
    WHERE id = NEW.job AND (iteration_count < NEW.number OR changed_at < NEW.created_at);
    RETURN NULL;
END
$$;
