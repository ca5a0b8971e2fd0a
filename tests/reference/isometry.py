"""Reference for the isometric maps of the core; corner arrays are (3, #F), and maps are complex.

Degener, Meseth, Klein, An Adaptable Surface Parameterization Method, IMR 2003; Smith, De Goes, Kim, Analytic
Eigensystems for Isotropic Distortion Energies, ACM TOG 38(1), 2019.
"""

import numpy as np


def derivatives(corner, gradient, z):
    """Return p and q of each triangle, whose map is w -> p w + q conj(w)."""
    return (gradient * z[corner]).sum(axis=0), (gradient.conj() * z[corner]).sum(axis=0)


def by_squares(A, B, weight):
    """Return the energy c a^weight as a function of A = |p|^2 and B = |q|^2; J = A - B is the Jacobian."""
    J = A - B
    return (A + B) / J * ((J + 1 / J) / 2) ** weight


def isometric_energy(corner, gradient, share, z, weight):
    p, q = derivatives(corner, gradient, z)
    A, B = np.abs(p) ** 2, np.abs(q) ** 2
    upright = A > B
    value = np.full(len(A), np.inf)
    value[upright] = by_squares(A[upright], B[upright], weight)
    return share * value


def first_and_second(A, B, weight):
    """Return the derivatives E_A, E_B, E_AA, E_AB and E_BB of the energy, by the product rule."""
    J = A - B
    c, c_A, c_B = (A + B) / J, -2 * B / J**2, 2 * A / J**2
    c_AA, c_AB, c_BB = 4 * B / J**3, -2 * (A + B) / J**3, 4 * A / J**3
    a, a_J = (J + 1 / J) / 2, (1 - J**-2.0) / 2
    h, h_J = a**weight, weight * a ** (weight - 1) * a_J
    h_JJ = weight * ((weight - 1) * a ** (weight - 2) * a_J**2 + a ** (weight - 1) / J**3)
    return (
        c_A * h + c * h_J,
        c_B * h - c * h_J,
        c_AA * h + 2 * c_A * h_J + c * h_JJ,
        c_AB * h + (c_B - c_A) * h_J - c * h_JJ,
        c_BB * h - 2 * c_B * h_J + c * h_JJ,
    )


def slope_and_hessian(corner, gradient, share, z, weight):
    """Return the gradient (6, #F) and the convexified Hessian (6, 6, #F) by x, then y, of the three corners.

    With respect to the real and imaginary parts of p and q, the Hessian is that of a function of |p| and |q|:
    E_r / r in the angular directions, and the second derivatives by |p| and |q| in the plane of p and q.
    Negative eigenvalues of this 4 by 4 matrix are clamped to 0.
    """
    p, q = derivatives(corner, gradient, z)
    r, s = np.abs(p), np.abs(q)
    E_A, E_B, E_AA, E_AB, E_BB = first_and_second(r * r, s * s, weight)
    u, v = p / r, np.where(s > 0, q, 1) / np.where(s > 0, s, 1)
    zero = np.zeros_like(r)
    basis = np.array([[u.real, u.imag, zero, zero], [zero, zero, v.real, v.imag]])  # directions of p and q
    normal = np.array([[-u.imag, u.real, zero, zero], [zero, zero, -v.imag, v.real]])
    plane = np.array(
        [[2 * E_A + 4 * r * r * E_AA, 4 * r * s * E_AB], [4 * r * s * E_AB, 2 * E_B + 4 * s * s * E_BB]]
    )
    hessian = np.einsum("iat,ijt,jbt->tab", basis, plane, basis)
    hessian += np.einsum("iat,it,ibt->tab", normal, np.array([2 * E_A, 2 * E_B]), normal)
    values, vectors = np.linalg.eigh(hessian)
    convex = np.einsum("tai,ti,tbi->tab", vectors, np.maximum(values, 0), vectors)
    g = gradient
    to_corners = (
        np.array(  # derivatives of the real and imaginary parts of p and q by x, then y, of the corners
            [
                np.concatenate((g.real, -g.imag)),
                np.concatenate((g.imag, g.real)),
                np.concatenate((g.real, g.imag)),
                np.concatenate((-g.imag, g.real)),
            ]
        )
    )
    by_parts = np.array([2 * E_A * p.real, 2 * E_A * p.imag, 2 * E_B * q.real, 2 * E_B * q.imag])
    slope = np.einsum("at,ait->it", by_parts, to_corners)
    return share * slope, share * np.einsum("ait,tab,bjt->ijt", to_corners, convex, to_corners)


def sum_outer_products(rows, own, across, entries):
    """Assemble the 2 x 2 blocks of the sum of row row^T; blocks with `across` < 0 are added transposed."""
    made = np.zeros((entries, 2, 2))
    for row in rows.reshape(-1, 2, 3, rows.shape[1]):  # axes: (x or y, corner, triangle)
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            np.add.at(made, own[k], np.einsum("at,bt->tab", row[:, k], row[:, k]))
            block = np.einsum("at,bt->tab", row[:, i], row[:, j])
            turned = across[k] < 0
            block[turned] = block[turned].transpose(0, 2, 1)
            np.add.at(made, np.where(turned, ~across[k], across[k]), block)
    return made.reshape(-1, 4)


def collapse_lengths(corner, gradient, z, direction):
    """Return the smallest positive root t of |p + t dp|^2 = |q + t dq|^2, where a triangle collapses."""
    (p, q), (dp, dq) = derivatives(corner, gradient, z), derivatives(corner, gradient, direction)
    a = np.abs(dp) ** 2 - np.abs(dq) ** 2
    b = (p.conj() * dp).real - (q.conj() * dq).real
    c = np.abs(p) ** 2 - np.abs(q) ** 2
    with np.errstate(divide="ignore", invalid="ignore"):
        total = -(b + np.copysign(np.sqrt(b * b - a * c), b))  # this sign avoids cancellation
        roots = np.stack((total / a, c / total))
    return np.where(roots > 0, roots, np.inf).min(axis=0)
