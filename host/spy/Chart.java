package ssv.spy;

import info.monitorenter.gui.chart.Chart2D;
import info.monitorenter.gui.chart.IAxis;
import info.monitorenter.gui.chart.ITrace2D;
import info.monitorenter.gui.chart.ZoomableChart;
import info.monitorenter.gui.chart.axis.AxisLinear;
import info.monitorenter.gui.chart.axis.scalepolicy.AxisScalePolicyManualTicks;
import info.monitorenter.gui.chart.labelformatters.LabelFormatterNumber;
import info.monitorenter.gui.chart.rangepolicies.RangePolicyFixedViewport;
import info.monitorenter.util.Range;
import java.awt.Color;
import java.text.DecimalFormat;
import java.text.DecimalFormatSymbols;
import java.util.Locale;

/** Charts as lcm-spy has them, with a name and a unit on each axis and round numbers; a drag of the mouse enlarges. */
final class Chart {
    /** Anybody may send a message; what is larger is none of ours, and would be hard to draw. */
    static final double MOST = 1e7;
    static final Color TRANSIT = new Color(0x0072b2), TRANSFER = new Color(0xe69f00), INK = new Color(0x1a1a1a), FAINT = new Color(0xd5d5d5);

    private Chart() {
    }

    static Chart2D of(String name, String x, String y, ITrace2D... traces) {
        Chart2D chart = new ZoomableChart();
        chart.setName(name);
        chart.setUseAntialiasing(true);
        chart.setBackground(Color.WHITE);
        chart.setGridColor(FAINT);
        chart.setPaintLabels(traces.length > 1);
        chart.setAxisXBottom(axis(), 0);
        chart.setAxisYLeft(axis(), 0);
        name(chart.getAxisX(), x); // a chart names an axis that it takes
        name(chart.getAxisY(), y);
        for (ITrace2D trace : traces) {
            chart.addTrace(trace);
        }
        return chart;
    }

    /** 1, 2 or 5 times a power of ten, not less than this. */
    static double roundStep(double least) {
        double power = Math.pow(10, Math.floor(Math.log10(least)));
        return power * (least <= power ? 1 : least <= 2 * power ? 2 : least <= 5 * power ? 5 : 10);
    }

    private static DecimalFormat digits() {
        return new DecimalFormat("0.#####", DecimalFormatSymbols.getInstance(Locale.ROOT));
    }

    /** A number of a scale in as few digits as it needs. */
    static String label(double number) {
        return digits().format(number);
    }

    private static AxisLinear<AxisScalePolicyManualTicks> axis() {
        return new AxisLinear<>(new LabelFormatterNumber(digits()), new AxisScalePolicyManualTicks());
    }

    private static void name(IAxis<?> axis, String title) {
        axis.setAxisTitle(new IAxis.AxisTitle(title));
        axis.setPaintGrid(true);
    }

    /** Adds a point, unless it is none that can be drawn. */
    static void add(ITrace2D trace, double x, double y) {
        if (Math.abs(x) < MOST && Math.abs(y) < MOST) {
            trace.addPoint(x, y);
        }
    }

    /** Shows such a stretch of x and of y. */
    static void scale(Chart2D chart, Range x, Range y) {
        synchronized (chart) { // which is painted by another thread
            scale(chart.getAxisX(), x, chart.getWidth() / 80);
            scale(chart.getAxisY(), y, chart.getHeight() / 30);
        }
    }

    private static void scale(IAxis<?> axis, Range range, int marks) {
        double step = roundStep(range.getExtent() / Math.max(marks, 2));
        axis.setRangePolicy(new RangePolicyFixedViewport(range));
        axis.setMajorTickSpacing(step);
        axis.setMinorTickSpacing(step);
    }
}
