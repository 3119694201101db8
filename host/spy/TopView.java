package ssv.spy;

import java.awt.BasicStroke;
import java.awt.Color;
import java.awt.Graphics;
import java.awt.Graphics2D;
import java.awt.RenderingHints;
import java.awt.geom.Ellipse2D;
import java.awt.geom.Line2D;
import java.awt.geom.Path2D;
import java.util.ArrayList;
import java.util.List;
import javax.swing.JComponent;
import ssv.leg_t;
import ssv.plan_t;
import ssv.pose_t;
import ssv.quote_t;

/** The way of a plan as seen from above: x_I to the right, y_I up, both to the same scale. */
final class TopView extends JComponent {
    private static final int STEPS = 40, EDGE = 44, TICK_PIXELS = 60;
    /** Anybody may send a plan; what is farther away is none of ours. */
    private static final double FAR_M = 1e6;

    /** The vehicle's centre along a leg. */
    private static final class Stretch {
        final boolean isTransfer;
        final List<double[]> points = new ArrayList<>();

        Stretch(boolean isTransfer) {
            this.isTransfer = isTransfer;
        }
    }

    private final List<Stretch> way = new ArrayList<>();
    /** From the vehicle that holds it to the middle of the beam, when it is mated and when it is docked. */
    private final List<double[][]> beams = new ArrayList<>();

    TopView() {
        setName("way");
    }

    void show(plan_t plan) {
        way.clear();
        beams.clear();
        for (leg_t leg : plan.legs) {
            Stretch stretch = new Stretch(leg.phase == leg_t.PHASE_TRANSFER);
            for (int i = 0; i <= STEPS; i++) {
                double[] p = along(leg, leg.length * i / STEPS);
                if (isNear(p)) {
                    stretch.points.add(p);
                }
            }
            if (!stretch.points.isEmpty()) {
                way.add(stretch);
            }
            if (stretch.isTransfer && beams.isEmpty()) {
                addBeam(leg.X_IS_start, plan.X_SB);
            }
        }
        if (plan.quote.status == quote_t.STATUS_OK) {
            addBeam(plan.quote.X_IS_final, plan.X_SB);
        }
        repaint();
    }

    private void addBeam(pose_t X_IS, pose_t X_SB) {
        double[] middle = rotated(X_IS.q, X_SB.p_m);
        for (int i = 0; i < 3; i++) {
            middle[i] += X_IS.p_m[i];
        }
        if (isNear(middle) && isNear(X_IS.p_m)) {
            beams.add(new double[][] {X_IS.p_m.clone(), middle});
        }
    }

    private static boolean isNear(double[] p) {
        return Math.abs(p[0]) < FAR_M && Math.abs(p[1]) < FAR_M;
    }

    // ---- Motion ----

    private static double[] cross(double[] a, double[] b) {
        return new double[] {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    }

    private static double[] rotated(double[] q, double[] v) {
        double[] e = {q[1], q[2], q[3]}, t = cross(e, v), u = cross(e, t);
        return new double[] {v[0] + 2 * (q[0] * t[0] + u[0]), v[1] + 2 * (q[0] * t[1] + u[1]), v[2] + 2 * (q[0] * t[2] + u[2])};
    }

    /** The vehicle's centre after a way along the leg's twist: straight, or round the axis of w_S. */
    private static double[] along(leg_t leg, double s) {
        double rate = Math.sqrt(leg.w_S[0] * leg.w_S[0] + leg.w_S[1] * leg.w_S[1] + leg.w_S[2] * leg.w_S[2]), angle = rate * s;
        double[] p = {s * leg.v_S[0], s * leg.v_S[1], s * leg.v_S[2]};
        if (Math.abs(angle) > 1e-9) {
            double[] axis = {leg.w_S[0] / rate, leg.w_S[1] / rate, leg.w_S[2] / rate}, across = cross(axis, p), back = cross(axis, across);
            double bend = 2 * Math.pow(Math.sin(angle / 2), 2) / angle;
            double fall = Math.abs(angle) < 1e-3 ? angle * angle / 6 : 1 - Math.sin(angle) / angle;
            for (int i = 0; i < 3; i++) {
                p[i] += bend * across[i] + fall * back[i];
            }
        }
        p = rotated(leg.X_IS_start.q, p);
        for (int i = 0; i < 3; i++) {
            p[i] += leg.X_IS_start.p_m[i];
        }
        return p;
    }

    // ---- Drawing ----

    /** Metres to pixels. */
    private static final class Scale {
        double perMetre, x0, y0;

        double x(double[] p) {
            return x0 + perMetre * p[0];
        }

        double y(double[] p) {
            return y0 - perMetre * p[1];
        }
    }

    private Scale scale() {
        double[] least = {Double.MAX_VALUE, Double.MAX_VALUE}, most = {-Double.MAX_VALUE, -Double.MAX_VALUE};
        List<double[]> all = new ArrayList<>();
        way.forEach(stretch -> all.addAll(stretch.points));
        beams.forEach(beam -> all.add(beam[1]));
        for (double[] p : all) {
            for (int i = 0; i < 2; i++) {
                least[i] = Math.min(least[i], p[i]);
                most[i] = Math.max(most[i], p[i]);
            }
        }
        Scale scale = new Scale();
        double wide = Math.max(most[0] - least[0], 0.5), tall = Math.max(most[1] - least[1], 0.5);
        scale.perMetre = Math.max(1e-6, Math.min((getWidth() - 2.0 * EDGE) / wide, (getHeight() - 2.0 * EDGE) / tall));
        scale.x0 = getWidth() / 2.0 - scale.perMetre * (least[0] + most[0]) / 2;
        scale.y0 = getHeight() / 2.0 + scale.perMetre * (least[1] + most[1]) / 2;
        return scale;
    }

    @Override
    protected void paintComponent(Graphics graphics) {
        Graphics2D g = (Graphics2D) graphics.create();
        g.setRenderingHint(RenderingHints.KEY_ANTIALIASING, RenderingHints.VALUE_ANTIALIAS_ON);
        g.setColor(Color.WHITE);
        g.fillRect(0, 0, getWidth(), getHeight());
        if (!way.isEmpty()) {
            Scale scale = scale();
            drawGrid(g, scale);
            drawWay(g, scale);
        }
        g.dispose();
    }

    private void drawGrid(Graphics2D g, Scale scale) {
        double step = Chart.roundStep(TICK_PIXELS / scale.perMetre);
        for (long i = (long) Math.ceil(-scale.x0 / scale.perMetre / step); scale.x0 + scale.perMetre * i * step < getWidth(); i++) {
            double x = scale.x0 + scale.perMetre * i * step;
            g.setColor(Chart.FAINT);
            g.draw(new Line2D.Double(x, 0, x, getHeight()));
            g.setColor(Chart.INK);
            g.drawString(Chart.label(i * step), (float) x + 3, getHeight() - 4);
        }
        for (long i = (long) Math.ceil((scale.y0 - getHeight()) / scale.perMetre / step); scale.y0 - scale.perMetre * i * step > 0; i++) {
            double y = scale.y0 - scale.perMetre * i * step;
            g.setColor(Chart.FAINT);
            g.draw(new Line2D.Double(0, y, getWidth(), y));
            g.setColor(Chart.INK);
            g.drawString(Chart.label(i * step), 4, (float) y - 3);
        }
        g.drawString("from above: x [m] to the right, y [m] up", 40, 16);
        g.setColor(Chart.TRANSIT);
        g.drawString("vehicle alone", 40, 32);
        g.setColor(Chart.TRANSFER);
        g.drawString("with the beam", 140, 32);
    }

    private void drawWay(Graphics2D g, Scale scale) {
        g.setStroke(new BasicStroke(6, BasicStroke.CAP_ROUND, BasicStroke.JOIN_ROUND));
        g.setColor(Color.GRAY);
        for (double[][] beam : beams) {
            g.draw(new Line2D.Double(scale.x(beam[0]), scale.y(beam[0]), scale.x(beam[1]), scale.y(beam[1])));
        }
        for (int k = 0; k < beams.size(); k++) {
            label(g, k + 1 < beams.size() ? "middle of the beam, start" : "middle of the beam, goal", scale.x(beams.get(k)[1]), scale.y(beams.get(k)[1]));
        }
        g.setStroke(new BasicStroke(2.5f, BasicStroke.CAP_ROUND, BasicStroke.JOIN_ROUND));
        for (Stretch stretch : way) {
            Path2D line = new Path2D.Double();
            for (double[] p : stretch.points) {
                if (line.getCurrentPoint() == null) {
                    line.moveTo(scale.x(p), scale.y(p));
                } else {
                    line.lineTo(scale.x(p), scale.y(p));
                }
            }
            g.setColor(stretch.isTransfer ? Chart.TRANSFER : Chart.TRANSIT);
            g.draw(line);
            double[] end = stretch.points.get(stretch.points.size() - 1);
            g.fill(new Ellipse2D.Double(scale.x(end) - 3, scale.y(end) - 3, 6, 6));
        }
        double[] start = way.get(0).points.get(0);
        g.setColor(Chart.INK);
        g.draw(new Ellipse2D.Double(scale.x(start) - 6, scale.y(start) - 6, 12, 12));
        label(g, "vehicle, start", scale.x(start), scale.y(start));
    }

    /** Beside a point, on the side where there is more room. */
    private void label(Graphics2D g, String text, double x, double y) {
        double left = x < getWidth() / 2.0 ? x + 10 : x - 10 - g.getFontMetrics().stringWidth(text);
        g.drawString(text, (float) left, (float) y + 4);
    }

    /** The points of each leg that are drawn [m]. */
    List<List<double[]>> drawn() {
        List<List<double[]>> legs = new ArrayList<>();
        way.forEach(stretch -> legs.add(stretch.points));
        return legs;
    }
}
