// fit → job → iteration → refit → trace → correction with the client that openapi-generator makes for C# (library httpclient).
//
//     RoundTrip.exe URL EXAMPLES

using System;
using System.IO;
using System.Linq;
using Flankfit.Api;
using Flankfit.Client;
using Flankfit.Model;
using Newtonsoft.Json;

public static class RoundTrip
{
    public static int Main(string[] arguments)
    {
        Func<string, string> text = name => File.ReadAllText(Path.Combine(arguments[1], name + ".json"));
        Action<bool, string> held = (holds, what) => { if (!holds) throw new Exception(what); };
        var configuration = new Configuration { BasePath = arguments[0] };
        var fits = new FitsApi(configuration);
        var jobs = new JobsApi(configuration);
        var iterations = new IterationsApi(configuration);

        var fit = fits.CreateFit(Read<FitRequest>(text("fit_grid")));
        Console.WriteLine("fit: {0} coefficients", fit.Coefficients.Count);

        var job = jobs.CreateJob(Read<NewJob>(text("job")));
        var made = iterations.CreateIteration(job.Id, Read<IterationRequest>(text("iteration")));
        held(iterations.GetIteration(job.Id, made.Number).Id == made.Id, "another iteration");
        Console.WriteLine("job {0}, iteration {1}", job.Id, made.Number);

        var refit = iterations.CreateIterationFit(job.Id, made.Number, Read<RefitRequest>(text("refit")));
        iterations.ChooseFit(job.Id, made.Number, new ChosenFit(fitId: refit.Id, reason: "round trip"));
        Console.WriteLine("refit {0} stands", refit.Id);

        var trace = iterations.GetTrace(job.Id);
        held(trace.Iterations.Count == 1 && trace.Iterations[0].Fits.Count == 2, "the trace has lost something");

        var request = Read<CorrectionRequest>(text("iteration_correction"));
        var correction = iterations.CreateIterationCorrection(job.Id, made.Number, request);
        var kept = iterations.GetIterationCorrection(job.Id, made.Number);
        var changes = correction.Result.Settings.Select(one => one.Change);
        held(kept.Result.Settings.Select(one => one.Change).SequenceEqual(changes), "another correction");
        var told = correction.Result.Settings.Select(one => one.Name + " " + one.Change.ToString("G3") + " " + one.Unit);
        Console.WriteLine("correction: " + string.Join(", ", told));
        Console.WriteLine("round trip: ok");
        return 0;
    }

    private static T Read<T>(string text)
    {
        return JsonConvert.DeserializeObject<T>(text);
    }
}
