"""fit → job → iteration → refit → trace → correction with the client that openapi-generator makes for Python.

    python round_trip.py URL EXAMPLES

EXAMPLES is the folder examples/requests. Each model must hold every value of the JSON that it was read from: a client
that loses or mistakes one fails here.
"""

import json
import math
import pathlib
import sys
from datetime import datetime

import flankfit_client as flankfit


def same(model, wire, at=""):
    """Whatever stands on the wire stands in the model."""
    if isinstance(wire, dict):
        for key, value in wire.items():
            assert key in model, f"{at}/{key} is lost"
            same(model[key], value, f"{at}/{key}")
    elif isinstance(wire, list):
        assert len(model) == len(wire), at
        for i, (a, b) in enumerate(zip(model, wire)):
            same(a, b, f"{at}/{i}")
    elif isinstance(wire, (int, float)) and not isinstance(wire, bool):
        assert math.isclose(model, wire, rel_tol=0, abs_tol=0), f"{at}: {model} for {wire}"
    elif isinstance(wire, str) and model != wire:
        # a time may be written with other digits after the second
        assert datetime.fromisoformat(model) == datetime.fromisoformat(wire), f"{at}: {model} for {wire}"
    else:
        assert model == wire, f"{at}: {model} for {wire}"


def held(answer):
    """The model of an answer that was asked for with its text."""
    same(json.loads(answer.data.to_json()), json.loads(answer.raw_data))
    return answer.data


def main(url, examples):
    def example(model, name):
        text = (pathlib.Path(examples) / f"{name}.json").read_text(encoding="utf-8")
        request = model.from_json(text)
        same(json.loads(request.to_json()), json.loads(text))
        return request

    with flankfit.ApiClient(flankfit.Configuration(host=url)) as client:
        fits, jobs = flankfit.FitsApi(client), flankfit.JobsApi(client)
        iterations = flankfit.IterationsApi(client)

        names = sorted(path.stem for path in pathlib.Path(examples).glob("fit_*.json"))
        assert len(names) >= 42, names
        for name in names:
            try:
                held(fits.create_fit_with_http_info(example(flankfit.FitRequest, name)))
            except flankfit.ApiException as problem:
                raise AssertionError(f"{name} is refused: {problem.body}") from problem
        print(f"{len(names)} requests for fits are sent as they are read")

        fit = held(fits.create_fit_with_http_info(example(flankfit.FitRequest, "fit_grid")))
        print(f"fit: {len(fit.coefficients)} coefficients")

        job = held(jobs.create_job_with_http_info(example(flankfit.NewJob, "job")))
        made = held(
            iterations.create_iteration_with_http_info(job.id, example(flankfit.IterationRequest, "iteration"))
        )
        again = held(iterations.get_iteration_with_http_info(job.id, made.number))
        assert again.id == made.id
        print(f"job {job.id}, iteration {made.number}")

        refit = held(
            iterations.create_iteration_fit_with_http_info(
                job.id, made.number, example(flankfit.RefitRequest, "refit")
            )
        )
        held(
            iterations.choose_fit_with_http_info(
                job.id, made.number, flankfit.ChosenFit(fit_id=refit.id, reason="round trip")
            )
        )
        print(f"refit {refit.id} stands")

        trace = held(iterations.get_trace_with_http_info(job.id))
        assert len(trace.iterations) == 1 and len(trace.iterations[0].fits) == 2

        request = example(flankfit.CorrectionRequest, "iteration_correction")
        correction = held(iterations.create_iteration_correction_with_http_info(job.id, made.number, request))
        kept = iterations.get_iteration_correction(job.id, made.number)
        assert [s.change for s in kept.result.settings] == [s.change for s in correction.result.settings]
        print("correction: " + ", ".join(f"{s.name} {s.change:.3g} {s.unit}" for s in correction.result.settings))

        try:
            jobs.create_job(flankfit.NewJob.model_construct(name=""))
            raise AssertionError("an empty name was taken")
        except flankfit.ApiException as problem:
            assert problem.status == 422 and "/name" in problem.body, problem
    print("round trip: ok")


if __name__ == "__main__":
    main(*sys.argv[1:])
