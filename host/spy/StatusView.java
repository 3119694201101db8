package ssv.spy;

import info.monitorenter.gui.chart.Chart2D;
import info.monitorenter.gui.chart.ITrace2D;
import info.monitorenter.gui.chart.traces.Trace2DLtd;
import info.monitorenter.util.Range;
import java.awt.BorderLayout;
import java.awt.Color;
import java.awt.Dimension;
import java.util.LinkedHashMap;
import java.util.Locale;
import java.util.Map;
import javax.swing.BorderFactory;
import javax.swing.JComponent;
import javax.swing.JPanel;
import javax.swing.JScrollPane;
import javax.swing.JTabbedPane;
import javax.swing.JTable;
import javax.swing.JTextArea;
import javax.swing.table.DefaultTableModel;
import ssv.planner_status_t;

/** What the planners on a channel do in a second, a tab for each: counters with their rates, and rates over time. */
final class StatusView implements Window.View<planner_status_t> {
    /** Anybody may send a status of any planner; those that were heard first stay. */
    private static final int PLANNERS_MAX = 16;

    private final JTabbedPane tabs = new JTabbedPane();
    private final Map<Long, Planner> planners = new LinkedHashMap<>();

    @Override
    public JComponent component() {
        return tabs;
    }

    @Override
    public void show(planner_status_t status) {
        Planner planner = planners.get(status.planner.planner_id);
        if (planner == null && planners.size() < PLANNERS_MAX) {
            planner = new Planner();
            planners.put(status.planner.planner_id, planner);
            tabs.addTab(String.format(Locale.ROOT, "planner %016x", status.planner.planner_id), planner.panel);
        }
        if (planner != null) {
            planner.show(status);
        }
    }

    private static final class Planner {
        private static final String[] COUNTERS = {"questions heard", "asked before", "for another planner", "crowded out", "undecodable",
            "batches", "plans", "prices", "infeasible", "overflows", "refused", "flights", "datagrams lost", "log lines lost"};
        private static final int HEARD = 0, PLANS = 6, PRICES = 7;
        private static final String[] LINKS = {"no vehicle", "vehicle silent", "vehicle heard"};
        private static final int KEPT = 600; // some ten minutes

        final JPanel panel = new JPanel(new BorderLayout());
        private final JTextArea words = new JTextArea(2, 40);
        private final DefaultTableModel rates = new DefaultTableModel(new Object[] {"", "in all", "in a second"}, COUNTERS.length) {
            @Override
            public boolean isCellEditable(int row, int column) {
                return false;
            }
        };
        private final ITrace2D heard = trace("questions", Color.GRAY), plans = trace("plans", Chart.TRANSIT), prices = trace("prices", Chart.TRANSFER);
        private final Chart2D chart = Chart.of("rates over time", "up for [s]", "in a second [1/s]", heard, plans, prices);
        private planner_status_t before;

        Planner() {
            words.setName("words");
            words.setEditable(false);
            words.setLineWrap(true);
            words.setWrapStyleWord(true);
            words.setBorder(BorderFactory.createEmptyBorder(6, 8, 6, 8));
            for (int i = 0; i < COUNTERS.length; i++) {
                rates.setValueAt(COUNTERS[i], i, 0);
            }
            JTable table = new JTable(rates);
            table.setName("rates");
            JScrollPane scroll = new JScrollPane(table);
            scroll.setPreferredSize(new Dimension(600, 280));
            JPanel top = new JPanel(new BorderLayout());
            top.add(words, BorderLayout.NORTH);
            top.add(scroll, BorderLayout.CENTER);
            panel.add(top, BorderLayout.NORTH);
            panel.add(chart, BorderLayout.CENTER);
        }

        private static ITrace2D trace(String name, Color color) {
            ITrace2D trace = new Trace2DLtd(KEPT, name);
            trace.setColor(color);
            return trace;
        }

        private static long[] counters(planner_status_t s) {
            return new long[] {s.received, s.repeated, s.not_for_us, s.crowded_out, s.rejected_undecodable, s.batches, s.accepted, s.quoted,
                s.infeasible, s.numeric_overflow,
                s.rejected_reused_id + s.rejected_stale_epoch + s.rejected_not_finite + s.rejected_range + s.rejected_not_unit
                    + s.rejected_singular + s.rejected_weights, s.flights, s.datagrams_lost, s.log_lines_lost};
        }

        void show(planner_status_t status) {
            long[] now = counters(status), then = before == null ? now : counters(before);
            double passed_s = before == null ? 0 : 1e-6 * (status.uptime_us - before.uptime_us);
            words.setText(inWords(status));
            for (int i = 0; i < now.length; i++) {
                rates.setValueAt(now[i] < 0 ? "unknown" : String.valueOf(now[i]), i, 1);
                rates.setValueAt(passed_s > 0 && now[i] >= 0 ? String.format(Locale.ROOT, "%.2f", (now[i] - then[i]) / passed_s) : "", i, 2);
            }
            if (passed_s > 0) {
                double up_s = 1e-6 * status.uptime_us;
                double most = 1;
                ITrace2D[] traces = {heard, plans, prices};
                int[] counted = {HEARD, PLANS, PRICES};
                for (int i = 0; i < traces.length; i++) {
                    Chart.add(traces[i], up_s, (now[counted[i]] - then[counted[i]]) / passed_s);
                    most = Math.max(most, traces[i].getMaxY());
                }
                Chart.scale(chart, new Range(heard.getMinX(), Math.max(heard.getMaxX(), heard.getMinX() + 10)), new Range(0, 1.1 * most));
            }
            before = status;
        }

        private static String inWords(planner_status_t s) {
            String link = s.link >= 0 && s.link < LINKS.length ? LINKS[s.link] : "link " + s.link;
            return String.format(Locale.ROOT, "Version %s, up for %.0f s; %s; %d questions wait; %.1f MB of memory.%n"
                + "Last plan in %.3f ms, longest in %.3f ms; last price in %.3f ms, longest in %.3f ms.", s.planner.version, 1e-6 * s.uptime_us,
                s.flying_request_id != 0 ? String.format(Locale.ROOT, "%s, flies request %016x", link, s.flying_request_id) : link, s.waiting,
                1e-6 * s.resident_bytes, 1e-3 * s.last_plan_us, 1e-3 * s.worst_plan_us, 1e-3 * s.last_quote_us, 1e-3 * s.worst_quote_us);
        }
    }
}
