-- The trace is append-only, whoever holds the connection.
CREATE TRIGGER iterations_no_update BEFORE UPDATE ON iterations
BEGIN
    SELECT RAISE (ABORT, 'iterations is append-only');
END;

CREATE TRIGGER iterations_no_delete BEFORE DELETE ON iterations
BEGIN
    SELECT RAISE (ABORT, 'iterations is append-only');
END;

CREATE TRIGGER nodes_no_update BEFORE UPDATE ON nodes
BEGIN
    SELECT RAISE (ABORT, 'nodes is append-only');
END;

CREATE TRIGGER nodes_no_delete BEFORE DELETE ON nodes
BEGIN
    SELECT RAISE (ABORT, 'nodes is append-only');
END;

CREATE TRIGGER fits_no_update BEFORE UPDATE ON fits
BEGIN
    SELECT RAISE (ABORT, 'fits is append-only');
END;

CREATE TRIGGER fits_no_delete BEFORE DELETE ON fits
BEGIN
    SELECT RAISE (ABORT, 'fits is append-only');
END;

CREATE TRIGGER fit_choices_no_update BEFORE UPDATE ON fit_choices
BEGIN
    SELECT RAISE (ABORT, 'fit_choices is append-only');
END;

CREATE TRIGGER fit_choices_no_delete BEFORE DELETE ON fit_choices
BEGIN
    SELECT RAISE (ABORT, 'fit_choices is append-only');
END;

CREATE TRIGGER decisions_no_update BEFORE UPDATE ON decisions
BEGIN
    SELECT RAISE (ABORT, 'decisions is append-only');
END;

CREATE TRIGGER decisions_no_delete BEFORE DELETE ON decisions
BEGIN
    SELECT RAISE (ABORT, 'decisions is append-only');
END;
