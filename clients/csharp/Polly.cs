// The shapes of Polly that the generated client mentions. It retries with them if it is told to, which the round trip
// does not; a real project takes the package Polly instead of this file.

using System;
using System.Threading.Tasks;

namespace JsonSubTypes
{
    internal static class Unused { }
}

namespace Polly
{
    public enum OutcomeType { Successful, Failure }

    public class PolicyResult<T>
    {
        public OutcomeType Outcome { get { throw new NotSupportedException(); } }
        public T Result { get { throw new NotSupportedException(); } }
        public Exception FinalException { get { throw new NotSupportedException(); } }
    }

    public interface ISyncPolicy<T> { PolicyResult<T> ExecuteAndCapture(Func<T> action); }
    public interface IAsyncPolicy<T> { Task<PolicyResult<T>> ExecuteAndCaptureAsync(Func<Task<T>> action); }

    public abstract class Policy<T> : ISyncPolicy<T>
    {
        public abstract PolicyResult<T> ExecuteAndCapture(Func<T> action);
    }

    public abstract class AsyncPolicy<T> : IAsyncPolicy<T>
    {
        public abstract Task<PolicyResult<T>> ExecuteAndCaptureAsync(Func<Task<T>> action);
    }
}
