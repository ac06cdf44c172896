# Both base images are arguments, so that a mirror or an image of your own can stand in:
#   docker build --build-arg RUST_IMAGE=registry.example/rust:1-bookworm --build-arg RUN_IMAGE=registry.example/cc -t flankfit .
# The symbols of exactly this program, for a debugger or a trace of addresses:
#   docker build --target symbols --output symbols .
ARG RUST_IMAGE=docker.io/library/rust:1.95-bookworm
ARG RUN_IMAGE=gcr.io/distroless/cc-debian12:nonroot

# The manifest with an empty file for every target that it may name. It stays the same, and with it the layer of the dependencies, as long as
# manifest, lock file and the names of targets do.
FROM ${RUST_IMAGE} AS manifest
WORKDIR /all
COPY . .
RUN mkdir /manifest \
 && cp -r --parents Cargo.toml */Cargo.toml engine/*/Cargo.toml benches/*/Cargo.toml Cargo.lock .cargo /manifest \
 && for target in src/lib.rs src/main.rs */src/lib.rs */src/main.rs engine/*/src/lib.rs benches/service/load.rs benches/*/main.rs engine/tests/formats/klingelnberg_file.rs tests/*.rs tests/*/main.rs; do \
      mkdir -p "/manifest/$(dirname "$target")" && echo 'fn main() {}' > "/manifest/$target"; \
    done

FROM ${RUST_IMAGE} AS build
WORKDIR /src
COPY --from=manifest /manifest .
RUN cargo build --profile dist --locked

# Then the program. The sources may be older than the empty ones that were just compiled, and cargo goes by time.
COPY build.rs build.rs
COPY migrations migrations
COPY examples examples
COPY engine engine
COPY src src
COPY web/index.html web/index.html
COPY web/app web/app
COPY web/vendor web/vendor
RUN touch src/lib.rs src/main.rs engine/src/lib.rs engine/*/src/lib.rs \
 && cargo build --profile dist --locked --bin flankfit \
 && mkdir -p /out/data \
 && objcopy --only-keep-debug target/dist/flankfit /out/flankfit.debug \
 && objcopy --strip-all --add-gnu-debuglink=/out/flankfit.debug target/dist/flankfit /out/flankfit

FROM scratch AS symbols
COPY --from=build /out/flankfit.debug /flankfit.debug

FROM ${RUN_IMAGE}
COPY --from=build /out/flankfit /usr/local/bin/flankfit
# The only writable place. It is owned by the user of the final image, and a new named volume takes that over.
COPY --from=build --chown=65532:65532 /out/data /data
USER 65532:65532
# where the database is without a setting; a variable here would stand against a file that names another one
WORKDIR /data
ENV FLANKFIT_BIND=0.0.0.0:8080 \
    FLANKFIT_LOG_FORMAT=json \
    SQLITE_TMPDIR=/data
VOLUME /data
EXPOSE 8080
HEALTHCHECK --interval=30s --timeout=5s --retries=3 CMD ["/usr/local/bin/flankfit", "healthcheck"]
ENTRYPOINT ["/usr/local/bin/flankfit"]
CMD ["serve"]
