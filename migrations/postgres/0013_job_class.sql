-- The class that an evaluation found, given by the writer; jobs have that of the evaluation that was kept last. Evaluations from before
-- have none, since their results may be compressed.
ALTER TABLE records ADD COLUMN class bigint CHECK (class BETWEEN 1 AND 11);
ALTER TABLE jobs ADD COLUMN class bigint;

CREATE FUNCTION note_class() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET class = NEW.class WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER class_of_jobs AFTER INSERT ON records FOR EACH ROW WHEN (NEW.kind = 'evaluation') EXECUTE FUNCTION note_class();

-- A purge takes away who did it, and the figures of flanks.
DROP TRIGGER fits_not_changed ON fits;
CREATE TRIGGER fits_not_changed BEFORE UPDATE ON fits FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge(
    '{"reason": null, "actor": null, "flank_figures": null, "spec": "", "result": "", "coefficients": null, "prior": null}'
);

DROP TRIGGER fit_choices_not_changed ON fit_choices;
CREATE TRIGGER fit_choices_not_changed BEFORE UPDATE ON fit_choices FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"reason": null, "actor": null}');

DROP TRIGGER decisions_not_changed ON decisions;
CREATE TRIGGER decisions_not_changed BEFORE UPDATE ON decisions FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"reason": null, "actor": null}');

DROP TRIGGER records_not_changed ON records;
CREATE TRIGGER records_not_changed BEFORE UPDATE ON records FOR EACH ROW
EXECUTE FUNCTION refuse_all_but_purge('{"request": "", "result": "", "gear": null, "actor": null}');

CREATE OR REPLACE FUNCTION take_away(of uuid) RETURNS void LANGUAGE sql SECURITY DEFINER SET search_path FROM CURRENT AS $$
    UPDATE iterations SET operator = NULL, note = NULL WHERE job = of;
    UPDATE nodes SET data = '' WHERE job = of;
    UPDATE fits SET reason = NULL, actor = NULL, flank_figures = NULL, spec = '', result = '', coefficients = NULL, prior = NULL
    WHERE job = of;
    UPDATE fit_choices SET reason = NULL, actor = NULL WHERE job = of;
    UPDATE decisions SET reason = NULL, actor = NULL WHERE job = of;
    UPDATE records SET request = '', result = '', gear = NULL, actor = NULL WHERE job = of;
    UPDATE audit SET actor = '' WHERE chain = of;
$$;
