# Both base images are arguments, so that a mirror or an image of your own can stand in:
#   docker build --build-arg RUST_IMAGE=registry.example/rust:1-bookworm --build-arg RUN_IMAGE=registry.example/cc -t flankfit .
ARG RUST_IMAGE=docker.io/library/rust:1-bookworm
ARG RUN_IMAGE=gcr.io/distroless/cc-debian12:nonroot

FROM ${RUST_IMAGE} AS build
WORKDIR /src

# Dependencies first: this layer is made again only when a manifest changes. The targets that the manifest names must
# exist, so they are empty here.
COPY Cargo.toml Cargo.lock ./
COPY .cargo .cargo
RUN mkdir -p src benches \
 && echo 'fn main() {}' > src/main.rs \
 && touch src/lib.rs \
 && for bench in $(sed -n '/^\[\[bench\]\]$/ { n; s/^name = "\(.*\)"$/\1/p }' Cargo.toml); do echo 'fn main() {}' > benches/$bench.rs; done \
 && cargo build --release --locked

# Then the program. The sources may be older than the empty ones that were just compiled, and cargo goes by time.
COPY migrations migrations
COPY examples examples
COPY src src
RUN touch src/lib.rs src/main.rs \
 && cargo build --release --locked --bin flankfit \
 && mkdir -p /out/data \
 && cp target/release/flankfit /out/flankfit

FROM ${RUN_IMAGE}
COPY --from=build /out/flankfit /usr/local/bin/flankfit
# The only writable place. It is owned by the user of the final image, and a new named volume takes that over.
COPY --from=build --chown=65532:65532 /out/data /data
USER 65532:65532
ENV FLANKFIT_BIND=0.0.0.0:8080 \
    FLANKFIT_DATABASE_URL=sqlite:///data/flankfit.db \
    FLANKFIT_LOG_FORMAT=json \
    SQLITE_TMPDIR=/data
VOLUME /data
EXPOSE 8080
HEALTHCHECK --interval=30s --timeout=5s --retries=3 CMD ["/usr/local/bin/flankfit", "healthcheck"]
ENTRYPOINT ["/usr/local/bin/flankfit"]
CMD ["serve"]
