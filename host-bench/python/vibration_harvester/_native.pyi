"""The compiled half of the package: texts of JSON, and arrays as the bytes of doubles."""

Pairs = list[tuple[str, str]]

def run(
    scene: str, set: Pairs, given: list[str], how: tuple[float | None, bool, bool]
) -> tuple[str, tuple[list[str], bytes] | None]: ...
def sweep(
    scene: str, set: Pairs, keys: list[str], points: list[list[float]], given: list[str], how: tuple[bool, bool]
) -> list[str]: ...
def command(given: list[str]) -> str: ...
def response_map(
    scene: str,
    set: Pairs,
    ranges: list[tuple[float, ...]],
    voltages: list[float],
    places: tuple[float, int, int],
    given: list[str],
    command: str,
) -> tuple[bytes, int, str, str, str, str]: ...
def look_up(
    image: bytes, fingerprint: int, places: list[list[float]], voltage: float | None
) -> tuple[bytes, bytes]: ...
