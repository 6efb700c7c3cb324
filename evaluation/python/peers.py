"""Peers of the identification, one request a line on stdin, one JSON object a line on stdout.

Requests are JSON: {"do": "load", "path", "count"} reads count doubles of u and count of y;
{"do": "slicot", "s", "n", "alg", "repeat"} runs SLICOT's IB01AD and IB01BD (its combined method, as
`ctrlsys` binds them) `repeat` times and gives the processor seconds of one run and the model;
{"do": "sippy"|"nfoursid", "s", "n"} likewise.
"""

import json
import sys
import time


def slicot(data, s, n, alg, repeat):
    import ctrlsys

    u, y = data
    start = time.process_time()
    for _ in range(repeat):
        _, r, _, _, info = ctrlsys.ib01ad(
            "N", alg, "N", "O", "N", "N", s, 1, 1, u, y, 0.0, -1.0
        )
        a, c, b, d, _, _, _, k, _, info_bd = ctrlsys.ib01bd(
            "C", "A", "K", s, n, 1, 1, len(u), r, 0.0
        )
    seconds = (time.process_time() - start) / repeat
    if info != 0 or info_bd not in (0,):
        return {"error": f"info {info}, {info_bd}"}
    return {"seconds": seconds, "a": a.tolist(), "b": b.tolist(), "c": c.tolist(), "d": d.tolist(), "k": k.tolist()}


def sippy(data, s, n):
    import contextlib
    import io

    u, y = data
    with contextlib.redirect_stdout(io.StringIO()):
        from sippy_unipi import system_identification

        start = time.process_time()
        m = system_identification(
            y.ravel(), u.ravel(), "N4SID", SS_f=s, SS_p=s, SS_fixed_order=n, SS_D_required=True
        )
        seconds = time.process_time() - start
    return {"seconds": seconds, "a": m.A.tolist(), "b": m.B.tolist(), "c": m.C.tolist(), "d": m.D.tolist()}


def nfoursid(data, s, n):
    import pandas
    from nfoursid.nfoursid import NFourSID

    u, y = data
    frame = pandas.DataFrame({"u": u.ravel(), "y": y.ravel()})
    start = time.process_time()
    job = NFourSID(frame, input_columns=["u"], output_columns=["y"], num_block_rows=s)
    job.subspace_identification()
    m, _ = job.system_identification(rank=n)
    seconds = time.process_time() - start
    return {"seconds": seconds, "a": m.a.tolist(), "b": m.b.tolist(), "c": m.c.tolist(), "d": m.d.tolist()}


def main():
    data = None
    for line in sys.stdin:
        request = json.loads(line)
        do = request.pop("do")
        try:
            if do == "load":
                import numpy

                both = numpy.fromfile(request["path"], dtype="<f8")
                count = request["count"]
                data = tuple(numpy.asfortranarray(x.reshape(-1, 1)) for x in (both[:count], both[count:]))
                answer = {}
            else:
                answer = {"slicot": slicot, "sippy": sippy, "nfoursid": nfoursid}[do](data, **request)
        except Exception as problem:  # a peer's failure is a result
            answer = {"error": f"{type(problem).__name__}: {problem}"}
        print(json.dumps(answer), flush=True)


main()
