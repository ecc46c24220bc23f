# The demo: the paper's tables checked, its platform and Dietmaier's solved, a page to look at.
#
#   docker build -t gsp . && docker run --rm gsp
#   docker run --rm gsp gsp solve @rubin-m2
#   docker run --rm -v "$PWD:/work" gsp gsp solve mine.yaml
FROM python:3.12-bookworm AS build
RUN apt-get update -qq && apt-get install -y -qq --no-install-recommends g++ cmake ninja-build
COPY pyproject.toml CMakeLists.txt README.md LICENSE /src/
COPY native /src/native
COPY gspcli /src/gspcli
COPY data /src/data
RUN python -m pip wheel --quiet --no-deps --wheel-dir /wheels /src

FROM python:3.12-slim-bookworm
COPY --from=build /wheels /wheels
RUN python -m pip install --quiet --no-cache-dir /wheels/*.whl && rm -r /wheels
WORKDIR /work
CMD ["sh", "-c", "gsp table all --check && gsp solve @example-6.8 && gsp solve @dietmaier && gsp view @example-6.8 -o example-6.8.html"]
