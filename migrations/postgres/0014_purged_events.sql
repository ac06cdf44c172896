-- Events of a job tell that it was purged.
ALTER TABLE events DROP CONSTRAINT events_kind_check;
ALTER TABLE events ADD CONSTRAINT events_kind_check
    CHECK (kind IN ('iteration', 'fit', 'decision', 'stream', 'operation', 'purged')) NOT VALID;
ALTER TABLE events VALIDATE CONSTRAINT events_kind_check;

CREATE FUNCTION tell_purge() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    PERFORM add_event(NEW.job, 'purged', NEW.at, NULL);
    RETURN NULL;
END
$$;
CREATE TRIGGER events_of_purges AFTER INSERT ON purges FOR EACH ROW EXECUTE FUNCTION tell_purge();
