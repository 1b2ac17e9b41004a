#!/usr/bin/env python3
"""Draws what build/chart has measured, and writes every figure that the texts quote.

usage: chart.py ROWS.csv MODEL.dat MESH.csv OUT

OUT-race.png, OUT-which.png, OUT-hints.png, OUT-model.png, OUT-mesh.png; OUT.md: the page with its
figures; OUT-caption.md: the paragraphs that the README shows. SPDX-License-Identifier: MIT
"""
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

plt.rcParams["font.size"] = 13  # read on a phone, too

COSTS = [0, 2, 10, 80]  # of shading, in probes: chart_costs in chart.c
TOLERANCES = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01]
LEVELS = [1, 4, 16, 64]
TIMES = np.logspace(-5, -2, 22)  # seconds a pixel
SCENES = ["sphere", "slab", "corner", "needles", "bear"]
MESH = ["body", "method", "tolerance", "seconds", *(f"error_{n}" for n in LEVELS + [256]), "unsure"]

# What a rival is called, and its colour: by Okabe and Ito, so that everyone can tell them apart.
FAMILIES = {
    "Lambert": (["lambert"], "#999999"),
    "one disk": (["disk"], "#cc79a7"),
    "lean probe": (["lean"], "#56b4e9"),
    "resampled": (
        ["resampled", "memo", "two-exits", "four-exits", "colours", "no-strata"],
        "#e69f00",
    ),
    "shared": (["shared", "shared-one"], "#d55e00"),
    "walk": (["walk"], "#0072b2"),
    "cloud": (["cloud"], "#009e73"),
}

# The qualities of a light hint, as chart.c names them and as a reader does.
HINTS = {
    "exact": "exact",
    "lamp": "lamp and sky, no shadows",
    "cosine": "n·l + .05",
    "wrong": "wrong side",
}


def load(path):
    with open(path, encoding="utf-8") as f:
        head = f.readline().strip("# \n")
    rows = pd.read_csv(path, comment="#", keep_default_na=False)
    for column in ["size", "seconds", "model", "thickness"]:
        rows[column] = pd.to_numeric(rows[column])

    # A world that was interrupted is left out, and is named.
    count = rows.groupby(["scene", "size"])["method"].transform("size")
    short = rows[count < count.groupby(rows["size"]).transform("max")]
    for scene, size in short[["scene", "size"]].drop_duplicates().itertuples(index=False):
        print(f"chart.py: {scene} at size {size:g} is not complete, and left out", file=sys.stderr)
    return head, rows.drop(short.index)


def curve(row, cost):
    """Seconds a pixel and total error, over the number of samples. Beyond 64 samples the noise
    goes on with the root. The walk's model is the truth's own (tests hold that): its error is 0."""
    model = 0.0 if row.method == "walk" or row.walks == 1 else row.model
    charge = cost * row.probe_seconds
    once = row.once_seconds + row.once_shaded * charge
    each = row.seconds + row.shaded * charge
    if row.method == "cloud":
        return np.array([once + each]), np.array([row.error_1])
    samples = np.array(LEVELS + [256, 1024, 4096, 16384], float)
    errors = [getattr(row, f"error_{n}") for n in LEVELS]
    noise = max(errors[-1] ** 2 - model**2, 1e-9)
    errors += [np.sqrt(model**2 + noise * 64 / n) for n in samples[4:]]
    return once + samples * each, np.maximum(errors, 1e-4)


def envelope(rows, cost, times=TIMES):
    """The least total error of any of the rows, at each time; infinite before the first sample."""
    best = np.full(len(times), np.inf)
    for row in rows.itertuples():
        t, e = curve(row, cost)
        here = np.exp(np.interp(np.log(times), np.log(t), np.log(e)))
        here[times < t[0]] = np.inf
        best = np.minimum(best, np.minimum.accumulate(here))
    return best


def time_to(rows, cost, target):
    """Seconds a pixel until some row, of a list, is down to that total error."""
    best = np.inf
    for row in rows:
        t, e = curve(row, cost)
        e = np.minimum.accumulate(e)
        if e[-1] > target:
            continue
        k = int(np.argmax(e <= target))
        if k == 0:
            best = min(best, t[0])
            continue
        part = np.log(e[k - 1] / target) / np.log(e[k - 1] / e[k])
        best = min(best, np.exp(np.log(t[k - 1]) + part * np.log(t[k] / t[k - 1])))
    return best


def rivals(rows, hinted):
    """All but the plan and but hints that no caller has."""
    hints = ["none", "cosine"] if hinted else ["none"]
    return rows[(rows.method != "plan") & rows.hint.isin(hints)]


def plans(rows, hinted, cost):
    hint = "cosine" if hinted else "none"
    return rows[(rows.method == "plan") & (rows.hint == hint) & (rows.kind == COSTS.index(cost))]


def world(rows, scene, size):
    return rows[(rows.scene == scene) & (rows["size"] == size)]


# ---- The plan against all


def judge(rows):
    """One line for each scene, size, cost and hint: how far the plan is from the frontier."""
    out = []
    for scene, size in rows[["scene", "size"]].drop_duplicates().itertuples(index=False):
        here = world(rows, scene, size)
        for hinted in [False, True]:
            field = rivals(here, hinted)
            for cost in COSTS:
                plan = plans(here, hinted, cost)
                best, mine = envelope(field, cost), envelope(plan, cost)
                fair = np.isfinite(mine) & np.isfinite(best)
                ratio = mine[fair] / best[fair]
                winner, quickest = first_to(by_family(field), cost, 0.05)
                out.append(
                    {
                        "scene": scene,
                        "size": size,
                        "hinted": hinted,
                        "cost": cost,
                        "mean": np.exp(np.log(ratio).mean()),
                        "worst": ratio.max(),
                        "time": time_to(list(plan.itertuples()), cost, 0.05) / quickest,
                        "winner": winner,
                    }
                )
    return pd.DataFrame(out)


# ---- Pictures


def finish(figure, path):
    figure.savefig(path, dpi=110)
    plt.close(figure)


def legend_above(figure, ax, height, size):
    """The lines of one panel, named above all panels."""
    figure.tight_layout(rect=(0, 0, 1, 0.93))
    figure.legend(
        *ax.get_legend_handles_labels(),
        loc="upper center",
        ncol=7,
        frameon=False,
        bbox_to_anchor=(0.5, height),
        fontsize=size,
        columnspacing=1.2,
    )


def race(rows, out):
    bodies = [
        ("thick", "sphere", 0.125),
        ("curved", "sphere", 1.0),
        ("thin, lit from behind", "slab", 1.0),
    ]
    figure, axes = plt.subplots(2, 3, figsize=(11, 7.6), sharex=True, sharey=True)
    times = np.logspace(-6.5, -1.7, 120)
    for k, (name, scene, size) in enumerate(bodies):
        here = rivals(world(rows, scene, size), False)
        for j, cost in enumerate([2, 80]):
            ax = axes[j, k]
            for family in ["Lambert", "one disk", "resampled", "shared", "walk", "cloud"]:
                methods, colour = FAMILIES[family]
                ax.plot(
                    times * 1e6,
                    100 * envelope(here[here.method.isin(methods)], cost, times),
                    color=colour,
                    lw=2.2,
                    label=family,
                )
            ax.plot(
                times * 1e6,
                100 * envelope(plans(world(rows, scene, size), False, cost), cost, times),
                color="black",
                lw=1.6,
                ls=(0, (1, 1.2)),
                label="the plan",
            )
            ax.set_xscale("log")
            ax.set_yscale("log")
            ax.set_ylim(1, 150)
            ax.set_xlim(0.3, 2e4)
            ax.grid(alpha=0.25)
            ax.set_yticks([1, 2, 5, 10, 20, 50, 100])
            ax.set_yticklabels(["1 %", "2 %", "5 %", "10 %", "20 %", "50 %", "100 %"])
            ax.minorticks_off()
            if j == 0:
                ax.set_title(name)
            if k == 0:
                ax.set_ylabel(f"shading costs {cost} probes\n\ntotal error")
            if j == 1:
                ax.set_xlabel("CPU time of a pixel, µs")
    figure.suptitle(
        "Thick bodies: Lambert or one disk.\nCurved and thin ones: a shared profile for a quick look, "
        "then the walk",
        fontsize=14,
        y=0.99,
    )
    legend_above(figure, axes[0, 0], 0.93, 13)
    finish(figure, f"{out}-race.png")


def by_family(field):
    """Lists of rows: pandas takes long to make them."""
    return {f: list(field[field.method.isin(m)].itertuples()) for f, (m, _) in FAMILIES.items()}


def first_to(families, cost, target):
    """The family that is down to that error first, and its time."""
    at = {f: time_to(rows, cost, target) for f, rows in families.items()}
    best = min(at, key=at.get)
    return best, at[best]


def which(rows, out):
    charges = np.logspace(-0.5, 2.5, 31)
    spots = rows[["scene", "size", "thickness"]].drop_duplicates().sort_values("thickness")
    figure, axes = plt.subplots(2, 2, figsize=(11, 8.4), sharex=True, sharey=True)
    used = set()
    panels = [(target, hinted) for target in (0.2, 0.05) for hinted in (False, True)]
    for panel, (target, hinted) in enumerate(panels):
        j, i = divmod(panel, 2)
        ax = axes[j, i]
        for k, (scene, size, _) in enumerate(spots.itertuples(index=False)):
            families = by_family(rivals(world(rows, scene, size), hinted))
            for c in charges:
                best, time = first_to(families, c, target)
                if not np.isfinite(time):
                    continue
                used.add(best)
                ax.bar(
                    k,
                    c * (10**0.1 - 1),
                    bottom=c / 10**0.05,
                    width=1,
                    color=FAMILIES[best][1],
                    lw=0,
                )
        ax.set_yscale("log")
        ax.set_ylim(0.3, 330)
        ax.set_xlim(-0.5, len(spots) - 0.5)
        ax.set_yticks([1, 10, 100])
        ax.set_yticklabels(["1", "10", "100"])
        ax.set_title(
            f"to {100 * target:.0f} % error, " + ("hinted by n·l + .05" if hinted else "no hint")
        )
        ax.set_xticks(range(len(spots)))
        ax.set_xticklabels(
            [f"{scene} {thick:.2g}" for scene, _, thick in spots.itertuples(index=False)],
            rotation=90,
        )
        if j == 1:
            ax.set_xlabel("body, and its thickness in diffuse mean free paths")
        if i == 0:
            ax.set_ylabel("shading cost, in probes")
    names = [f for f in FAMILIES if f in used]
    handles = [plt.Rectangle((0, 0), 1, 1, color=FAMILIES[f][1]) for f in names]
    figure.suptitle("The method that is the first to reach a total error", y=0.99)
    figure.tight_layout(rect=(0, 0, 1, 0.93))
    figure.legend(
        handles, names, loc="upper center", ncol=7, frameon=False, bbox_to_anchor=(0.5, 0.96)
    )
    finish(figure, f"{out}-which.png")


def noise2(row):
    return max(row.error_1**2 - row.model**2, 1e-9)


def hint_table(rows):
    """Variance with each hint over that without, one sample, 8 candidates, own exit."""
    table = {}
    for method in ["resampled", "shared"]:
        for hint in ["cosine", "lamp", "exact", "wrong"]:
            ratio = []
            for scene in SCENES:
                here = world(rows, scene, 1.0)
                here = here[(here.method == method) & (here.setting == 8)]
                pick = {h: noise2(here[here.hint == h].iloc[0]) for h in ["none", hint]}
                ratio.append(pick[hint] / pick["none"])
            table[method, hint] = ratio
    return table


def hints(table, out):
    figure, ax = plt.subplots(figsize=(8.6, 4.2))
    width = 0.15
    colours = ["#009e73", "#56b4e9", "#e69f00", "#d55e00"]
    for k, (hint, label) in enumerate(HINTS.items()):
        height = np.array(table["resampled", hint])
        ax.bar(
            np.arange(len(SCENES)) + (k - 1.5) * width,
            height - 1,
            width,
            bottom=1,
            label=label,
            color=colours[k],
        )
    ax.axhline(1, color="black", lw=1)
    ax.set_yscale("log")
    ax.set_xticks(range(len(SCENES)))
    ax.set_xticklabels(SCENES)
    ax.set_ylabel("variance over that without hint")
    ax.set_title(
        "A hint that knows lamp and sky lowers the variance; n·l + .05 raises it here", fontsize=12
    )
    ax.legend(frameon=False, ncol=2, loc="upper left")
    ax.set_ylim(0.1, 1000)
    ax.set_yticks([0.1, 1, 10, 100])
    ax.set_yticklabels(["0.1", "1", "10", "100"])
    figure.tight_layout()
    finish(figure, f"{out}-hints.png")


def on_mesh(rows, out):
    """The race on a mesh, as far down as the truth is known. Beyond 256 samples the noise goes on
    with the root of their number. Plans that walk everywhere have the walk's picture, and like the
    walk no error of the model."""
    levels = LEVELS + [256]
    figure, axes = plt.subplots(1, 3, figsize=(11, 4.3), sharey=True)
    times = np.logspace(-6.3, -1.7, 120)
    walk = rows[rows.method == "walk"].set_index("body").error_256
    samples = np.array(levels + [1024, 4096, 16384], float)
    titles = {
        "thick": "thick: a tube of 16 dmfp",
        "curved": "curved: 4 dmfp",
        "thin": "thin: 0.7 dmfp",
    }
    for ax, body in zip(axes, titles):
        for family in ["Lambert", "one disk", "resampled", "shared", "walk", "plan"]:
            best = np.full(len(times), np.inf)
            for row in rows[(rows.body == body) & (rows.method == family)].itertuples():
                squares = np.array([getattr(row, f"error_{n}") ** 2 for n in levels])
                walks = row.error_256 == walk[body]
                model = 0.0 if walks else max((256 * squares[4] - 64 * squares[3]) / 192, 0.0)
                more = model + max(squares[4] - model, 0.0) * 256 / samples[5:]
                errors = np.sqrt(np.concatenate([squares, more]))
                if not walks:
                    errors = np.maximum(errors, row.unsure)
                here = np.exp(
                    np.interp(np.log(times), np.log(samples * row.seconds), np.log(errors))
                )
                here[times < row.seconds] = np.inf
                best = np.minimum(best, np.minimum.accumulate(here))
            look = {"color": "black", "lw": 1.6, "ls": (0, (1, 1.2)), "label": "the plan"}
            if family != "plan":
                look = {"color": FAMILIES[family][1], "lw": 2.2, "label": family}
            ax.plot(times * 1e6, 100 * best, **look)
        floor = 100 * rows[(rows.body == body) & (rows.method == "resampled")].unsure.max()
        ax.axhspan(1, floor, color="#dddddd", lw=0, label="noise of the truth")
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.set_ylim(1, 200)
        ax.grid(alpha=0.25)
        ax.set_yticks([1, 2, 5, 10, 20, 50, 100])
        ax.set_yticklabels(["1 %", "2 %", "5 %", "10 %", "20 %", "50 %", "100 %"])
        ax.minorticks_off()
        ax.set_title(titles[body], fontsize=12)
        ax.set_xlabel("CPU time of a pixel, µs")
    axes[0].set_ylabel("total error against the volume")
    figure.suptitle(
        "On a mesh of 50,000 triangles, where rays cost what they cost", fontsize=13, y=0.975
    )
    legend_above(figure, axes[0], 0.935, 10.5)
    finish(figure, f"{out}-mesh.png")


def profiles(data, out):
    names = ["Burley by dmfp", "Burley by mfp", "dipole", "better dipole"]
    figure, ax = plt.subplots(figsize=(7.4, 4.2))
    data = data[data[0] == data[0].min()]
    colours = ["#0072b2", "#e69f00", "#009e73", "#d55e00"]
    for k, name in enumerate(names):
        ax.plot(data[1], 100 * data[3 + k], "os^D"[k] + "-", color=colours[k], label=name)
    ax.set_xlabel("albedo of a scattering")
    ax.set_ylabel("error of the profile, %")
    ax.set_ylim(bottom=0)
    ax.grid(alpha=0.25)
    ax.legend(frameon=False)
    ax.set_title("Profiles against a walk through the half space")
    figure.tight_layout()
    finish(figure, f"{out}-model.png")


# ---- Words and figures


def mean(values):
    return float(np.exp(np.mean(np.log(values))))


def percent(x):
    return f"{100 * x:.1f} %"


def table_of(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return lines + ["| " + " | ".join(cells) + " |" for cells in rows] + [""]


def misses(verdict):
    """Where the plan is more than 20 % off: scenes, with the costs of shading."""
    words = []
    for scene in SCENES:
        costs = [str(c) for c in verdict[(verdict.scene == scene) & (verdict["mean"] > 1.2)].cost]
        if costs:
            words.append(f"{scene} ({', '.join(costs)})")
    return ", ".join(words) or "nowhere"


def exceptions(plain, hinted):
    """A sentence on where the plan is more than 20 % off; none where it is not."""
    places = [(misses(plain), "without hints"), (misses(hinted), "with hints")]
    words = [f"{where} {how}" for where, how in places if where != "nowhere"]
    return f" Not so, by scene and cost: {'; '.join(words)}." if words else ""


def cases(verdict, hinted):
    return verdict[(verdict["size"] == 1.0) & (verdict.hinted == hinted)]


def caption_of(verdict):
    """What the README says below the picture."""
    plain, hinted = cases(verdict, False), cases(verdict, True)
    near = [int((v["mean"] <= 1.2).sum()) for v in (plain, hinted)]
    return [
        "Total error, noise and model together, against a random walk through the volume.",
        f"**With the best of its six tolerances `sss_plan_for` is within 20 % of the best rival at its "
        f"best setting, in {near[0]} of {len(plain)} cases of scene and shading cost, and in {near[1]} "
        "with n·l + .05 as light hint.**",
    ]


FEELERS = 7  # rays of a lookup on the mesh that find the radius: TRACER_FEELERS in tracer.h


def verdict_lines(verdict):
    """What the caption leaves out."""
    plain, hinted = cases(verdict, False), cases(verdict, True)
    always = [int((v.worst <= 1.2).sum()) for v in (plain, hinted)]
    return [
        "That is the mean over 10 µs to 10 ms a pixel; at every single time it is so in "
        f"{always[0]} and {always[1]} cases.{exceptions(plain, hinted)}",
        "",
    ]


def mesh_lines(mesh):
    unsure = mesh[mesh.method == "resampled"].groupby("body").unsure.max()
    walk = mesh[mesh.method == "walk"].set_index("body").seconds
    plan = mesh[(mesh.method == "plan") & (mesh.tolerance == 0.01)].set_index("body").seconds
    extra = plan / walk - 1  # this plan walks everywhere on the last two bodies
    return [
        "![the same on a mesh of 50,000 triangles](chart-mesh.png)",
        "",
        "The same race on a mesh, in a path tracer ([chart-mesh.csv](chart-mesh.csv)). The plan and the shared exits have a "
        f"light hint. The curves of Lambert and of profiles end at {percent(unsure['thick'])} on the thick body, "
        f"{percent(unsure['curved'])} on the curved and {percent(unsure['thin'])} on the thin one: errors below may be noise "
        f"of the truth. In each lookup the plan pays for {FEELERS} rays that find the radius of the body: "
        f"{extra['curved']:.1f} of a walk's sample on the curved body, {extra['thin']:.1f} on the thin one. A renderer finds "
        "radii once for each vertex.",
        "",
    ]


def plan_lines(verdict):
    rows = []
    for scene in SCENES:
        for cost in COSTS:
            cells = [scene, str(cost)]
            for hinted in [False, True]:
                here = verdict[
                    (verdict.scene == scene) & (verdict["size"] == 1.0) & (verdict.cost == cost)
                ]
                v = here[here.hinted == hinted].iloc[0]
                time = f"{v.time:.2f}" if np.isfinite(v.time) else "not there"
                cells += [f"{v['mean']:.2f}, {v.worst:.2f}", time, v.winner]
            rows.append(cells)
    other = []
    for size in sorted(set(verdict["size"]) - {1.0}):
        part = [verdict[(verdict["size"] == size) & (verdict.hinted == h)] for h in [False, True]]
        near = [f"{int((v['mean'] <= 1.2).sum())} of {len(v)}" for v in part]
        other += [
            f"With {size:g} times the mean free path it is within 20 % in {near[0]} cases without hints, in {near[1]} "
            f"hinted.{exceptions(*part)}",
            "",
        ]
    return (
        [
            "## The plan, case by case",
            "",
            "Error of `sss_plan_for` with the best of its tolerances (50 to 1 %) over the least error of any rival at the "
            "same time: geometric mean over time, and worst. Then its time to 5 % total error over that of the quickest "
            "rival, and which that is. With hints the rivals may use them or not.",
            "",
        ]
        + table_of(
            [
                "scene",
                "cost",
                "no hint: mean, worst",
                "time",
                "quickest",
                "hinted: mean, worst",
                "time",
                "quickest",
            ],
            rows,
        )
        + other
        + [
            "On thick bodies in smooth light Lambert is nearer to the truth than the plan can know: the plan depends on the body "
            "and the pixel, not on the light.",
            "",
        ]
    )


def hint_lines(table):
    rows = []
    for hint, label in HINTS.items():
        cells = [label]
        for method in ["resampled", "shared"]:
            r = table[method, hint]
            cells.append(f"{mean(r):.2f} ({min(r):.2f} to {max(r):.2f})")
        rows.append(cells)
    return [
        "## What a hint is worth",
        "",
        "![variance with hints of four qualities](chart-hints.png)",
        "",
        "Variance of one sample with 8 candidates over that without a hint: geometric mean, least and most over the five "
        "scenes. n·l + .05 knows nothing of the sky, which is bright here.",
        "",
    ] + table_of(["hint", "one exit of its own", "a colour's exits, shared over 8 x 8"], rows)


def product(rows, cost):
    """The least of variance times time of one sample, over the settings."""
    best = np.inf
    for row in rows.itertuples():
        best = min(best, noise2(row) * (row.seconds + row.shaded * cost * row.probe_seconds))
    return best


def sampling_lines(rows):
    """Noise alone: variance times time over that of the lean probe."""
    ways = [
        ("memo", "none", "memo 16-05: independent, disk and sphere"),
        ("resampled", "none", "the default mix"),
        ("four-exits", "none", "four exits"),
        ("colours", "none", "an exit a colour"),
        ("shared", "none", "the same, shared over 8 x 8"),
        ("resampled", "cosine", "the default mix, n·l + .05"),
        ("shared", "cosine", "shared, n·l + .05"),
    ]
    out = []
    for method, hint, label in ways:
        cells = [label]
        for cost in COSTS:
            ratio = []
            for scene in SCENES:
                here = world(rows, scene, 1.0)
                mine = here[(here.method == method) & (here.hint == hint)]
                ratio.append(product(mine, cost) / product(here[here.method == "lean"], cost))
            cells.append(f"{mean(ratio):.2f}")
        out.append(cells)
    strata = []
    for scene in SCENES:
        here = world(rows, scene, 1.0)
        here = here[(here.hint == "cosine") & (here.setting == 8)]
        a, b = [here[here.method == m].iloc[0] for m in ["resampled", "no-strata"]]
        strata.append((a.error_16**2 - a.model**2) / (b.error_16**2 - b.model**2))
    return (
        [
            "## Noise alone",
            "",
            "Variance of pixels times CPU time of one sample, each way with its best number of candidates, over those of a lean "
            "plain probe that shades all its hits (King et al. 2013, written without the header): geometric mean over the five "
            "scenes. Below 1 the way is the better one.",
            "",
        ]
        + table_of(["", *[f"shading costs {c} probes more" for c in COSTS]], out)
        + [
            f"Strata over 16 samples of a pixel (`sss_begin_sample`): {mean(strata):.2f} of the variance without.",
            "",
        ]
    )


def block_lines(rows):
    out = []
    for scene in SCENES:
        here = world(rows, scene, 1.0)
        here = here[(here.hint == "none") & (here.setting == 8)]
        cells = [scene]
        for method in ["colours", "shared"]:
            r = here[here.method == method].iloc[0]
            cells += [
                percent(np.sqrt(max(r.error_1**2 - r.model**2, 0.0))),
                percent(np.sqrt(max(r.block_1**2 - r.model_block**2, 0.0))),
            ]
        out.append(cells)
    return [
        "## Pixels and blocks",
        "",
        "Noise of one sample, of pixels and of the mean over a block of 8 x 8. Sharing takes the noise of pixels away, and "
        "correlates what is left: a block gains nothing.",
        "",
    ] + table_of(["scene", "own exits: pixels", "block", "shared: pixels", "block"], out)


def page(head, rows, mesh, verdict, table, out):
    caption = caption_of(verdict)
    lines = (
        [
            "# The race",
            "",
            f"Written by `demos/study/chart.py` from the rows of one run, `{head}`: `make chart` measures them. The error is "
            "relative, the root mean square over the pixels of tiles of 8 x 8, with a floor of a tenth of the mean light. The "
            f"truth is known to {percent(rows.truth_error.mean())} a pixel, whose square is taken off. Beyond 64 samples the "
            "noise is continued with the root of their number. Shading an exit is charged with 0 to 80 probes on top of one "
            "sample of the lamp. A cloud pays its part of the build, spread over all pixels of a 480 x 270 picture that see "
            "the object; the plan pays for four rays a pixel that find the radius of the body.",
            "",
            "![total error over time](chart-race.png)",
            "",
        ]
        + caption
        + [""]
        + verdict_lines(verdict)
        + mesh_lines(mesh)
        + [
            "![which method is first](chart-which.png)",
            "",
        ]
    )
    lines += plan_lines(verdict) + sampling_lines(rows) + hint_lines(table) + block_lines(rows)
    lines += [
        "## Profiles on a half space",
        "",
        "![errors of the profiles by albedo](chart-model.png)",
        "",
        "What they cost on curved and thin bodies: [model_error.png](model_error.png), `make model-error`.",
    ]
    with open(f"{out}.md", "w", encoding="utf-8") as f:
        f.write("\n".join(lines) + "\n")
    with open(f"{out}-caption.md", "w", encoding="utf-8") as f:
        f.write("\n".join(caption) + "\n")


def main():
    if len(sys.argv) == 2 and sys.argv[1] == "--help":
        print(__doc__)
        return 0
    if len(sys.argv) != 5:
        print("chart.py: wants ROWS.csv MODEL.dat MESH.csv OUT; --help says more", file=sys.stderr)
        return 2
    path = sys.argv[1]
    try:
        head, rows = load(path)
        path = sys.argv[3]
        mesh = pd.read_csv(path, usecols=MESH)
        path = sys.argv[2]
        model = pd.read_csv(path, sep=r"\s+", comment="#", header=None)
    except (OSError, ValueError, KeyError) as error:
        print(f"chart.py: cannot read {path}: {error}", file=sys.stderr)
        return 2
    out = sys.argv[4]
    verdict = judge(rows)
    table = hint_table(rows)
    race(rows, out)
    which(rows, out)
    hints(table, out)
    profiles(model, out)
    on_mesh(mesh, out)
    page(head, rows, mesh, verdict, table, out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
